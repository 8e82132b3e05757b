"""The extension's zip has its sources, a manifest, wheels that may be bundled, and a size to be downloaded."""

import tomllib
from pathlib import Path
from zipfile import ZipFile

import pytest

import flowabs_nodes
from flowabs_nodes.errors import FlowabsError
from tools.blender import extension, wheels


def wheel(folder: Path, name: str, size: int = 10, license_file: str = "licenses/LICENSE") -> Path:
    file = folder / f"{name}-1.0-py3-none-any.whl"
    file.parent.mkdir(parents=True, exist_ok=True)
    with ZipFile(file, "w") as made:
        made.writestr(f"{name}-1.0.dist-info/{license_file}", "x" * size)
    return file


@pytest.fixture
def no_downloads(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Have pip make two small wheels, and NumPy; return its commands."""
    commands: list[list[str]] = []

    def call(failure: str, command: list[str]) -> None:
        commands.append(command)
        if "download" in command:
            for name in ("flowabs_nodes", "tqdm", "numpy"):
                wheel(Path(command[command.index("--dest") + 1]), name)
        else:
            wheel(Path(command[command.index("--wheel-dir") + 1]), "flowabs_nodes")

    monkeypatch.setattr(wheels, "call", call)
    return commands


def test_a_zip_for_each_python_and_platform(no_downloads: list[list[str]], tmp_path: Path) -> None:
    made = [file for _, file in extension.build(extension.TARGETS, tmp_path)]
    version = flowabs_nodes.__version__
    assert [file.name for file in made] == [
        f"flowabs_blender-{version}-blender-{blender}-{platform}.zip"
        for blender, platforms in {
            "4.5": ["linux-x64", "windows-x64", "macos-arm64", "macos-x64"],
            "5.2": ["linux-x64", "windows-x64", "macos-arm64"],
        }.items()
        for platform in platforms
    ]
    downloads = [" ".join(command) for command in no_downloads if "download" in command]
    assert len(no_downloads) == len(downloads) + 1
    assert "--python-version 3.11 --platform win_amd64 numpy==1.26.* colorama " in downloads[1]
    assert "--python-version 3.13 --platform macosx_12_0_arm64 numpy==2.3.* " in downloads[-1]


def test_what_a_zip_holds(no_downloads: list[list[str]], tmp_path: Path) -> None:
    ((_, made),) = extension.build([each for each in extension.TARGETS if each.platform.name == "macos-x64"], tmp_path)
    with ZipFile(made) as file:
        names = set(file.namelist())
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
    sources = {path.relative_to(extension.SOURCE).as_posix() for path in extension.SOURCE.rglob("*.py")}
    packed = {"wheels/flowabs_nodes-1.0-py3-none-any.whl", "wheels/tqdm-1.0-py3-none-any.whl"}
    assert names == {*sources, *packed, "blender_manifest.toml", "LICENSE", "NOTICE"}
    assert {name.removeprefix("./") for name in manifest["wheels"]} == packed
    assert manifest["platforms"] == ["macos-x64"]
    assert (manifest["blender_version_min"], manifest["blender_version_max"]) == ("4.5.0", "5.1.0")
    assert manifest["license"] == ["SPDX:Apache-2.0", "SPDX:MIT", "SPDX:MPL-2.0"]
    assert list(manifest["permissions"]) == ["files"]


def test_the_same_sources_make_the_same_zip(no_downloads: list[list[str]], tmp_path: Path) -> None:
    made = [
        next(file for _, file in extension.build(extension.TARGETS[:1], tmp_path / name)).read_bytes() for name in "ab"
    ]
    assert made[0] == made[1]


def test_a_zip_that_is_too_large_is_not_left(
    no_downloads: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(extension, "LIMIT", 1000)
    assert extension.main([str(tmp_path), "--blender", "5.2", "--platform", "linux-x64"]) == 2
    said = capsys.readouterr().err
    assert "at most 0.001 are meant: " in said
    assert "tqdm-1.0-py3-none-any.whl 0.0" in said
    assert list(tmp_path.iterdir()) == []


def test_wheels_that_may_not_be_bundled(
    no_downloads: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(FlowabsError, match="carry its licence"):
        wheels._check_license(wheel(tmp_path, "tqdm", license_file="METADATA"))
    monkeypatch.delitem(wheels.LICENSES, "tqdm")  # type: ignore[arg-type]
    with pytest.raises(FlowabsError, match=r"tqdm-1\.0.*is not known to be free to bundle"):
        list(extension.build(extension.TARGETS[:1], tmp_path))


def test_a_blender_that_does_not_run_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert extension.main([str(tmp_path), "--blender", "5.2", "--platform", "macos-x64"]) == 2
    assert "Blender 5.2 does not run on macos-x64" in capsys.readouterr().err
