"""Interpreters are found or named, environments made once, and what fails is said."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from flowabs_nodes.errors import CommandError
from tools.blender import __main__ as command
from tools.blender import environments, interpreters

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

    monkeypatch.setattr(environments, "_call", call)
    blender = environments.BLENDERS["4.5"]
    for _ in range(2):
        own = environments.make(blender, Path(sys.executable), tmp_path)
    assert own == tmp_path / "blender-4.5" / "bin" / "python"
    assert len(calls) == 2
    assert calls[1][-4:] == list(blender.requirements)
    (tmp_path / "blender-4.5" / environments.STAMP).write_text("older")
    environments.make(blender, Path(sys.executable), tmp_path)
    assert len(calls) == 4


def test_what_pip_said_is_told() -> None:
    with pytest.raises(environments.FlowabsError, match=r"cannot do it: .* ended with 3\nthe reason"):
        environments._call("cannot do it", ["sh", "-c", "echo the reason >&2; exit 3"])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--blender", "4.6"], "Blender 4.6 is not one of 4.5, 5.2"),
        (["--python", "3.13"], "expected a version and an interpreter"),
        (["--python", f"2.7={sys.executable}"], "expected a version and an interpreter"),
    ],
)
def test_a_wrong_command(arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command.main([str(tmp_path), *arguments]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(("codes", "expected"), [((0, 0), 0), ((0, 1), 1)])
def test_every_blender_is_tested(
    codes: tuple[int, int], expected: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    monkeypatch.setattr(command, "find", lambda version: Path(version))
    monkeypatch.setattr(command, "make", lambda blender, python, cache: Path(blender.version))
    left = list(codes)
    ran: list[tuple[str, list[str]]] = []

    def run(python: Path, arguments: list[str], timeout: float) -> int:
        ran.append((str(python), arguments))
        return left.pop(0)

    monkeypatch.setattr(command, "_run", run)
    assert command.main([str(tmp_path), "-k", "knobs"]) == expected
    assert ran == [("4.5", ["-k", "knobs"]), ("5.2", ["-k", "knobs"])]
    assert ("Blender 5.2" in capsys.readouterr().err) == (expected == 1)


def test_a_hang_is_a_failure(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def hang(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("pytest", 1)

    monkeypatch.setattr(subprocess, "run", hang)
    assert command._run(Path(sys.executable), [], 1) == 1
    assert "no end after 1 seconds" in capsys.readouterr().err
