"""Interpreters are found or named, environments made once, and what fails is said."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from flowabs_nodes.errors import CommandError
from tools.blender import __main__ as command
from tools.blender import environments, extension, interpreters, suites, wheels

HERE = f"{sys.version_info.major}.{sys.version_info.minor}"


@pytest.fixture
def no_interpreters(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Empty the PATH and pyenv; return the folder of pyenv."""
    monkeypatch.setenv("PATH", str(tmp_path / "empty"))
    monkeypatch.setenv("PYENV_ROOT", str(tmp_path))
    return tmp_path


def script(file: Path, text: str) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(f"#!/bin/sh\n{text}\n", encoding="utf-8")
    file.chmod(0o755)
    return file


def test_this_interpreter_is_of_its_version() -> None:
    assert interpreters.is_version(Path(sys.executable), HERE)
    assert not interpreters.is_version(Path(sys.executable), "2.7")
    assert not interpreters.is_version(Path("/nowhere/python"), HERE)


def test_no_interpreter_is_an_error(no_interpreters: Path) -> None:
    with pytest.raises(CommandError, match=r"no Python 3\.13 is installed here.*--python 3\.13="):
        interpreters.find("3.13")


def test_a_stand_in_on_the_path_is_passed_over(no_interpreters: Path) -> None:
    script(no_interpreters / "empty" / "python3.13", "echo 'version not chosen' >&2; exit 127")
    good = script(no_interpreters / "versions" / "3.13.5" / "bin" / "python", "echo 3.13")
    assert interpreters.find("3.13") == good


def test_an_environment_is_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[list[str]] = []

    def call(failure: str, words: list[str]) -> None:
        calls.append(words)
        script(tmp_path / "blender-4.5" / "bin" / "python", "")

    monkeypatch.setattr(environments, "call", call)
    wanted = environments.BLENDERS["4.5"].with_flowabs
    for _ in range(2):
        own = environments.make(wanted, Path(sys.executable), tmp_path)
    assert own == tmp_path / "blender-4.5" / "bin" / "python"
    assert len(calls) == 2
    assert calls[1][-4:] == list(wanted.requirements)
    (tmp_path / "blender-4.5" / environments.STAMP).write_text("older")
    environments.make(wanted, Path(sys.executable), tmp_path)
    assert len(calls) == 4


def test_what_pip_said_is_told() -> None:
    with pytest.raises(environments.FlowabsError, match=r"cannot do it: .* ended with 3\nthe reason"):
        environments.call("cannot do it", ["sh", "-c", "echo the reason >&2; exit 3"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--blender", "4.6"], "Blender 4.6 is not one of 4.5, 5.2"),
        (["--suite", "windows"], "suite windows is not one of tests, installed, window (did you mean 'window'?)"),
        (["--python", "3.13"], "expected a version and an interpreter"),
        (["--python", f"2.7={sys.executable}"], "expected a version and an interpreter"),
    ],
)
def test_a_wrong_command(arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([str(tmp_path), *arguments]) == 2
    assert said in capsys.readouterr().err


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Make no environment; return the names of those that were asked for."""
    names: list[str] = []

    def make(place: suites.Workplace, environment: environments.Environment) -> Path:
        names.append(environment.name)
        return Path(environment.name)

    monkeypatch.setattr(suites.Workplace, "make", make)
    return names


@pytest.mark.parametrize(("codes", "expected"), [((0, 0), 0), ((0, 1), 1)])
def test_every_blender_is_tested(
    codes: tuple[int, int],
    expected: int,
    made: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    left = list(codes)
    ran: list[tuple[str, list[str]]] = []

    def start(run: suites.Run, arguments: list[str], timeout: float) -> int:
        ran.append((str(run.python), arguments))
        return left.pop(0)

    monkeypatch.setattr(suites.Run, "start", start)
    assert command.main([str(tmp_path), "--suite", "tests", "-k", "knobs"]) == expected
    assert ran == [("blender-4.5", ["-k", "knobs"]), ("blender-5.2", ["-k", "knobs"])]
    assert ("tests failed in Blender 5.2" in capsys.readouterr().err) == (expected == 1)


def test_the_extension_is_built_for_this_machine_and_tested_where_flowabs_is_not(
    made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(targets: list[extension.Target], out: Path) -> Iterator[tuple[extension.Target, Path]]:
        for target in targets:
            yield target, out / f"{target.platform.name}.zip"

    monkeypatch.setattr(extension, "build", build)
    here = wheels.here().name
    place = suites.Workplace(tmp_path, [environments.BLENDERS["5.2"]])
    runs = list(suites.installed(place))
    assert made == ["clean-5.2"]
    assert [run.told for run in runs] == [{"FLOWABS_EXTENSION": str(tmp_path / "extensions" / f"{here}.zip")}]


def test_a_window_needs_a_blender_and_a_display(
    no_interpreters: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main([str(tmp_path), "--suite", "window"]) == 2
    said = capsys.readouterr().err
    assert "no program blender is installed here" in said
    assert "--suite tests,installed" in said


def test_a_window_has_the_python_of_its_blender(no_interpreters: Path, made: list[str], tmp_path: Path) -> None:
    blender = script(no_interpreters / "empty" / "blender", "echo PYTHON 3.12")
    script(no_interpreters / "empty" / "xvfb-run", "")
    (run,) = suites.in_window(suites.Workplace(tmp_path))
    assert made == ["window-3.12"]
    assert run.told == {"FLOWABS_BLENDER": str(blender)}


def test_a_hang_is_a_failure(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def hang(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("pytest", 1)

    monkeypatch.setattr(subprocess, "run", hang)
    assert suites.Run("a", Path(sys.executable), "tests").start([], 1) == 1
    assert "no end after 1 seconds" in capsys.readouterr().err
