"""Output that cannot be printed stops no frame; what would drive a terminal is escaped."""

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from flowabs_nodes.cli.streams import SafeStream, one_line, printable
from tests.cli.test_run import GRAPH, pixels, write

ROOT = Path(__file__).resolve().parents[2]
FLOWABS = [sys.executable, "-m", "flowabs_nodes"]
posix = pytest.mark.skipif(os.name == "nt", reason="a shell's way to close a stream")
full = pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, ünïcode, 日本語\u3000.exr\n\ta", "plain, ünïcode, 日本語\u3000.exr\n\ta"),
        ("\x1b[31mred\x07\r", "\\x1b[31mred\\x07\\x0d"),
        ("\x9b31m\x7f\x00", "\\x9b31m\\x7f\\x00"),
        ("caf\udce9.exr", "caf\\xe9.exr"),
        ("\ud800", "\\ud800"),
        ("gpj.\u202eexr", "gpj.\\u202eexr"),
        ("a\u2028b", "a\\u2028b"),
    ],
)
def test_what_a_terminal_would_obey_is_escaped(text, shown):
    assert printable(text) == shown


def test_a_line_is_one_line():
    assert one_line("a\nb\x1b") == "a\\nb\\x1b"


class Broken(io.StringIO):
    def write(self, text):
        raise OSError(28, "No space left on device")


def test_trouble_is_said_once_and_then_all_is_dropped():
    said = io.StringIO()
    stream = SafeStream(Broken(), "stdout", said_on=SafeStream(said, "stderr"))
    for _ in range(3):
        assert stream.write("a frame\n") == 8
        stream.flush()
    assert said.getvalue() == "flowabs: warning: stdout cannot be written: No space left on device\n"
    assert not stream.reader_left
    assert not stream.isatty()


# ---------------------------------------------------------------------- the process


@pytest.fixture
def shot(tmp_path):
    """A folder with a graph and three frames."""
    (tmp_path / "brighter.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    for frame in (1, 2, 3):
        write(tmp_path / f"in.{frame:04}.exr", frame / 10)
    return tmp_path


def shell(line, folder):
    """Run a line of shell in which "flowabs" is this one; return its result."""
    words = f'flowabs() {{ "{sys.executable}" -m flowabs_nodes "$@"; }}; set -o pipefail; {line}'
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    result = subprocess.run(
        ["bash", "-c", words], cwd=folder, env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True
    )
    assert "Traceback" not in result.stderr
    return result


@posix
@pytest.mark.parametrize("options", ["", "--json"])
@pytest.mark.parametrize(
    ("end", "said"),
    [
        (">&-", "it is closed"),
        pytest.param(">/dev/full", "No space left", marks=full),
        ("| head -c 1 >/dev/null", "Broken pipe"),
    ],
)
def test_frames_are_made_whatever_becomes_of_stdout(shot, end, said, options):
    result = shell(f"flowabs run ./brighter.json -i in.####.exr -o out.####.exr {options} {end}", shot)
    assert result.returncode == 0
    assert [line for line in result.stderr.splitlines() if "stdout" in line] == [
        line for line in result.stderr.splitlines() if said in line
    ]
    assert result.stderr.count("cannot be written") <= 1
    if "head" not in end:  # which may have read all before it left
        assert said in result.stderr
    for frame in (1, 2, 3):
        assert pixels(shot / f"out.{frame:04}.exr") is not None


@posix
def test_frames_are_made_where_nothing_at_all_can_be_said(shot):
    assert shell("flowabs run ./brighter.json -i in.####.exr -o out.####.exr <&- >&- 2>&-", shot).returncode == 0
    assert all(pixels(shot / f"out.{frame:04}.exr") is not None for frame in (1, 2, 3))
    (shot / "in.0002.exr").unlink()
    again = "flowabs run ./brighter.json -i in.####.exr -o new.####.exr --frames 1-3 >&- 2>&-"
    assert shell(again, shot).returncode == 1, "the exit code still tells of a frame that is missing"


@posix
@pytest.mark.parametrize("command", ["check lines", "nodes", "nodes fbl", "graphs", "schema", "--help", "--version"])
def test_a_listing_that_cannot_be_printed_has_failed_unless_its_reader_has_seen_enough(command, tmp_path):
    closed = shell(f"flowabs {command} >&-", tmp_path)
    assert (closed.returncode, closed.stderr) == (1, "flowabs: warning: stdout cannot be written: it is closed\n")
    if Path("/dev/full").exists():
        assert shell(f"flowabs {command} >/dev/full", tmp_path).returncode == 1
    left = shell(f"flowabs {command} | true", tmp_path)
    assert (left.returncode, left.stderr) == (0, "")


@posix
@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "lines", "-i", b"\x1b[31mr\xe9d.exr", "-o", "out.exr"],
        ["run", b"gr\xff\x1b[2J.json"],
        ["check", b"gr\xff\x1b[2J.json"],
        ["nodes", b"et\x1b[31m\xff"],
        ["run", "lines", b"--n\x1b[31m\xff"],
        [b"ru\x1b[31m\xff"],
    ],
)
def test_what_stands_in_a_name_does_not_drive_the_terminal(arguments, tmp_path):
    result = subprocess.run([*FLOWABS, *arguments], capture_output=True, cwd=tmp_path, env=_here())
    assert result.returncode == 2
    assert b"Traceback" not in result.stderr
    assert b"\x1b" not in result.stderr + result.stdout
    assert result.stderr.decode("utf-8").replace("\n", "").isprintable()


def _here():
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))}
