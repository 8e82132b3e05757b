"""The summary of a run: which frames failed and why, and the command that makes these again."""

from flowabs_nodes.cli.summary import failed_lines, profile_lines
from flowabs_nodes.engine.report import FrameReport, Report
from flowabs_nodes.errors import ReadError, WriteError


def failed(frame, error):
    return FrameReport(frame, "failed", error=error.at(frame=frame))


def gone(frame):
    return failed(frame, ReadError("no such file", file=f"in.{frame}.exr", node="plate"))


def full(frame):
    return failed(frame, WriteError("not made: the disk is full"))


def again(frames):
    return f"again {frames}"


def test_nothing_is_said_where_nothing_failed():
    assert failed_lines(Report((FrameReport(1, "done"),), 0), again) == []


def test_frames_that_failed_alike_share_a_line():
    report = Report((gone(5), FrameReport(6, "done"), full(9), gone(7), full(10), full(11), full(12)), 1)
    assert failed_lines(report, again) == [
        "6 frames failed:",
        "  frames 5,7: node plate: no such file",
        "  frames 9-12: not made: the disk is full",
        "To make just these again:",
        "  again 5-9x2,10-12",
    ]


def test_a_parameter_is_named_once():
    error = WriteError("keep_layers: the plate has no layer 'a'", parameter="keep_layers", node="out")
    assert failed_lines(Report((failed(1, error),), 1), again)[1] == (
        "  frame 1: node out: keep_layers: the plate has no layer 'a'"
    )


def test_a_run_that_was_stopped_says_what_makes_the_rest():
    report = Report((FrameReport(1, "done"), gone(2)), 130, not_made=(3, 4))
    assert failed_lines(report, again)[-2:] == ["To make what is not there:", "  again 2-4"]
    assert failed_lines(Report((), 130, not_made=(3, 4)), again) == ["To make what is not there:", "  again 3-4"]


def test_a_profile_is_a_table_with_straight_columns():
    rows = [
        {"node": "(finishing comp)", "type": "", "frames": 3, "runs": 3, "seconds": 3.0, "longest": 2.0},
        {"node": "a", "type": "read", "frames": 5, "runs": 9, "seconds": 1.0, "longest": 0.5},
    ]
    _, head, first, second = profile_lines(rows)
    assert len(head) == len(first) == len(second)
    assert first.split() == ["(finishing", "comp)", "3", "3.000", "75.0%", "1.000", "2.000"]
    assert second.split() == ["a", "read", "5", "1.000", "25.0%", "0.200", "0.500"]
    assert profile_lines([]) == []
