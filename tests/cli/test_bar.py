"""The bar of a terminal: what it shows, and that it lives while a node runs long."""

import io
import re
import sys
import time

import pytest

from flowabs_nodes.cli import progress
from flowabs_nodes.cli.bar import Bar, clock
from flowabs_nodes.cli.progress import Loudness
from flowabs_nodes.engine.report import Report

NODE = {"event": "node", "frame": 1, "node": "flow", "type": "etf", "status": "started", "seconds": None}
FRAME = {"event": "frame", "frame": 1, "status": "done", "seconds": 1.0, "files": ["out.0001.exr"]}


class Terminal(io.StringIO):
    """Keeps what is drawn."""

    def isatty(self):
        return True

    def last(self):
        """Return the last state of the last line."""
        return self.getvalue().rstrip("\n").rpartition("\r")[2]


@pytest.fixture
def terminal(monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    return stream


@pytest.fixture
def bar(terminal):
    with Bar(Loudness.NORMAL, str) as shown:
        shown.event({"event": "start", "graph": "toon", "frames": 4})
        yield shown


def until(condition, seconds=20.0):
    """Wait until a condition is true, and return whether it is."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


def test_a_run_on_a_terminal(flowabs, fake_run, monkeypatch):
    monkeypatch.setattr(progress, "on_a_terminal", lambda: True)
    code, out, err = flowabs("run", "lines")
    assert code == 1
    assert "2/2 frames" in err
    assert re.search(r"\d+(\.\d+)? frames/s|\? frames/s", err)
    assert re.search(r"(\d:\d\d|\?) left", err)
    assert "is cut short" in err
    assert "gradient reference" in out
    assert "1 done, 1 failed" in out


def test_it_shows_the_node_at_work_and_for_how_long_without_any_event(bar, terminal):
    bar.event(NODE | {"progress": 0.0})
    assert until(lambda: "frame 1: flow (etf) 0." in terminal.last())
    before = terminal.last()
    assert until(lambda: terminal.last() != before), "nothing happens, and yet it counts the seconds"


def test_a_narrow_terminal_has_the_node_and_its_seconds(bar, terminal):
    for width, shown in (
        (200, " left, frame 1: flow (etf) "),
        (70, " left, frame 1: flow "),
        (45, "frames, frame 1: flow "),
    ):
        bar._bar.dynamic_ncols = lambda stream, width=width: (width, 20)
        bar.event(NODE | {"progress": 0.0})
        assert until(lambda: len(terminal.last()) <= width and shown in terminal.last()), width  # noqa: B023
        assert terminal.last().endswith(" s")


def test_it_moves_within_a_frame(bar, terminal):
    bar.event(NODE | {"progress": 0.0})
    bar.event(NODE | {"status": "done", "seconds": 1.0, "progress": 0.5})
    assert until(lambda: " 12%" in terminal.last()), "half of one of four frames"
    bar.event(FRAME)
    assert " 25%" in terminal.last()
    assert "1/4 frames" in terminal.last()


def test_work_inside_of_other_work_is_shown_while_it_lasts(bar, terminal):
    bar.event(NODE | {"node": "out", "type": "write", "progress": 0.5})
    bar.event(NODE | {"node": "(finishing comp)", "type": "", "progress": 0.5})
    assert until(lambda: "frame 1: (finishing comp) " in terminal.last())
    bar.event(NODE | {"node": "(finishing comp)", "type": "", "status": "done", "seconds": 1.0, "progress": 0.5})
    assert until(lambda: "frame 1: out (write) " in terminal.last())


def test_frames_in_parallel_add_up(bar, terminal):
    bar.event(NODE | {"progress": 0.5})
    bar.event(NODE | {"frame": 2, "progress": 0.5})
    assert until(lambda: " 25%" in terminal.last())


def test_frames_a_second_are_those_that_were_made(bar, terminal):
    bar.event(FRAME | {"status": "skipped", "seconds": 0.0})
    assert "? frames/s, ? left" in terminal.last()
    bar.event(FRAME | {"frame": 2})
    assert re.search(r"\d frames/s, \d+:\d\d left", terminal.last())


def test_a_line_stands_above_the_bar(bar, terminal, monkeypatch):
    monkeypatch.setattr(sys, "stderr", terminal)  # pytest has put its own there since the fixture
    bar.line("a warning", error=True)
    lines = terminal.getvalue().split("\n")
    assert lines[-2].endswith("\ra warning")
    assert "0/4 frames" in lines[-1]


def test_the_end_leaves_the_bar_and_no_thread(bar, terminal, capsys):
    bar.event(FRAME)
    thread = bar._thread
    bar.end(Report((), 0, 1.0))
    assert not thread.is_alive()
    drawn = terminal.getvalue()
    time.sleep(0.6)
    assert terminal.getvalue() == drawn


@pytest.mark.parametrize(
    ("seconds", "text"), [(0, "0:00"), (7.4, "0:07"), (59.6, "1:00"), (760, "12:40"), (11100, "3:05:00")]
)
def test_clock(seconds, text):
    assert clock(seconds) == text
