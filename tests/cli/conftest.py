"""The command line as a function, and a stand-in for the engine behind it."""

import pytest

from flowabs_nodes import cli
from flowabs_nodes.engine.profile import NodeTime
from flowabs_nodes.engine.report import FrameReport, Note, Report, end_event, frame_event, note_event, start_event
from flowabs_nodes.errors import ReadError

RENDER_SEQUENCE = "flowabs_nodes.engine.render_sequence.render_sequence"

DONE = FrameReport(
    1001,
    "done",
    ("out.1001.exr", "out.1001.png"),
    1.25,
    notes=(Note("gradient reference max = 83.2", "flow"), Note("clipped", "out", warning=True)),
)

FAILED = FrameReport(1002, "failed", ("out.1002.exr",), 0.5, ReadError("is cut short", file="in.1002.exr", frame=1002))

PROFILE = (NodeTime("flow", "etf", 2, 3.0, 2.0, 2), NodeTime("lines", "fdog", 2, 1.0, 0.5, 3))


@pytest.fixture
def flowabs(capsys):
    """Return a function that runs a command and returns exit code, stdout, stderr."""

    def run(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


@pytest.fixture
def fake_run(monkeypatch):
    """Put a stand-in in place of render_sequence: it notes its calls here, and tells of two frames."""
    calls = []

    def render_sequence(graph, options, *, profile, on_event):
        calls.append((graph, options, profile))
        on_event(start_event("toon", 2))
        on_event(note_event(Note("soft: fbl@1 read as fbl@2")))
        for frame in (DONE, FAILED):
            for note in frame.notes:
                on_event(note_event(note, frame.frame))
            on_event(frame_event(frame))
        report = Report((DONE, FAILED), 1, 2.0, profile=PROFILE if profile else None)
        on_event(end_event(report))
        return report

    monkeypatch.setattr(RENDER_SEQUENCE, render_sequence)
    return calls
