"""``--log-file``: every line of a run, with the time; and files that are no log are left alone."""

import os
import re
from pathlib import Path

import pytest

from flowabs_nodes.cli.log_file import LogFile, open_log
from flowabs_nodes.cli.progress import Loudness
from tests.cli.test_run import names, run, shot  # noqa: F401 - fixtures

BOTH = ("-i", "in.####.exr", "-o", "out.####.exr")
STAMP = re.compile(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d[+-]\d\d:\d\d ")


def lines(path):
    """Return the lines of a log without their times."""
    found = Path(path).read_text(encoding="utf-8").splitlines()
    assert all(STAMP.match(line) for line in found)
    return [STAMP.sub("", line, count=1) for line in found]


def test_every_line_of_the_run_is_there_too(run):  # noqa: F811
    code, out, err = run(*BOTH, "--frames", "1001-1004", "--log-file", "logs/night/run.log")
    assert code == 1
    found = lines("logs/night/run.log")
    assert found[0].endswith("--frames 1001-1004 --log-file logs/night/run.log")
    assert sorted(found[1:]) == sorted([*out.splitlines(), *err.splitlines()])


def test_it_is_appended_to(run):  # noqa: F811
    Path("run.log").write_text("before\n", encoding="utf-8")
    for _ in range(2):
        run(*BOTH, "--log-file", "run.log")
    text = Path("run.log").read_text(encoding="utf-8")
    assert text.startswith("before\n")
    assert len(re.findall(r"3 (done|skipped) in", text)) == 2


@pytest.mark.parametrize("options", [["-q"], ["--json"], ["--json", "-q"]])
def test_it_has_all_where_the_screen_has_little_or_events(run, options):  # noqa: F811
    run(*BOTH, "--log-file", "run.log", *options)
    found = lines("run.log")
    assert sum(line.startswith("frame") and " done " in line for line in found) == 3


def test_verbose_is_so_there_too(run):  # noqa: F811
    run(*BOTH, "--log-file", "run.log", "-v")
    assert any("plate: reads in.1001.exr" in line for line in lines("run.log"))


def test_what_is_wrong_with_a_command_is_there(run):  # noqa: F811
    code, _, err = run(*BOTH, "--set", "stops=9", "--log-file", "run.log")
    assert code == 2
    assert lines("run.log")[1:] == err.splitlines()


@pytest.mark.parametrize(
    "name",
    [
        "in.1001.exr",
        "new.png",
        "brighter.json",
        "folder",
        "in.1001.exr/run.log",
        "fifo",
        "",
        "/proc/none/run.log",
        "../run.log",
    ],
)
def test_what_cannot_be_a_log_is_refused_before_anything_is_made(run, shot, name):  # noqa: F811
    Path("folder").mkdir()
    if hasattr(os, "mkfifo"):
        os.mkfifo("fifo")
    before = {path: path.read_bytes() for path in shot.iterdir() if path.is_file()}
    listed = names(shot)
    code, out, err = run(*BOTH, "--root", shot, "--log-file", name)
    assert (code, out) == (2, "")
    assert err.startswith("flowabs: ")
    assert names(shot) == listed
    assert {path: path.read_bytes() for path in before} == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_log_that_becomes_full_stops_no_frame(run):  # noqa: F811
    code, out, err = run(*BOTH, "--log-file", "/dev/full")
    assert code == 0
    assert out.splitlines()[-1].startswith("3 done")
    assert err == "flowabs: warning: /dev/full cannot be written: No space left on device\n"


def test_a_line_is_there_as_soon_as_it_is_said(tmp_path):
    path = tmp_path / "run.log"
    with LogFile(open_log(str(path), graph="lines", root=None), Loudness.NORMAL, str, ("lines",)) as log:
        log.line("frame 1  done")
        assert lines(path)[-1] == "frame 1  done"


def test_a_run_that_is_stopped_says_so(tmp_path):
    path = tmp_path / "run.log"
    log = LogFile(open_log(str(path), graph="lines", root=None), Loudness.NORMAL, str, ("lines",))
    with pytest.raises(KeyboardInterrupt), log:
        raise KeyboardInterrupt
    assert lines(path)[-1] == "stopped"
