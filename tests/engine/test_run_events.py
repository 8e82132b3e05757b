"""The events of a whole run: their order, each frame's profile, what the last one says."""

import json

from flowabs_nodes.engine.report import FrameReport, Note, Report
from flowabs_nodes.engine.run_events import RunEvents
from flowabs_nodes.engine.stopwatch import Timing
from flowabs_nodes.errors import ReadError
from tests.engine.sequences import plates, run

NOTE = Note("linear", "plate")
DONE = [
    FrameReport(frame, "done", ("a.exr",), 1.0, None, (NOTE,), (Timing("flow", frame, 2.0),)) for frame in (1, 2, 3)
]


def test_notes_come_before_their_frame_and_shared_ones_before_the_end():
    events = []
    tell = RunEvents(events.append, {"flow": "etf"}, profile=True)
    tell.start("toon", 3)
    for frame in DONE:
        tell.frame(frame)
    tell.end(Report(tuple(DONE), 0))
    assert events == json.loads(json.dumps(events))
    kinds = [each["event"] for each in events]
    assert kinds == ["start", "note", *["frame", "profile"] * 3, "shared-note", "end"]
    assert events[3] == {
        "event": "profile",
        "frame": 1,
        "nodes": [{"node": "flow", "type": "etf", "frames": 1, "runs": 1, "seconds": 2.0, "longest": 2.0}],
    }
    shared = {"frames": "1-3", "count": 3, "node": "plate", "level": "note", "text": "linear"}
    assert events[-2] == {"event": "shared-note", **shared}
    assert events[-1]["failed_frames"] is None


def test_the_end_says_which_frames_failed():
    events = []
    tell = RunEvents(events.append, {})
    error = ReadError("no such file")
    tell.end(Report(tuple(FrameReport(frame, "failed", error=error) for frame in (5, 9, 10, 11)), 1))
    assert events[-1]["failed_frames"] == "5,9-11"


def test_what_is_read_and_what_is_there_already_are_details(tmp_path):
    shot = plates(tmp_path / "in", 1, 2, 4)
    told = []
    for missing in ("nearest", None):
        events = []
        options = {"missing": missing} if missing else {}
        run(shot, tmp_path / "out.####.exr", frames="1-4" if missing else "1-2", on_event=events.append, **options)
        told.append({(each["frame"], each["node"], each["text"]) for each in events if each["event"] == "detail"})
        if missing:
            (held,) = [each for each in events if each["event"] == "note" and "in its place" in each["text"]]
            assert (held["frame"], held["node"]) == (3, "plate")
            assert "plate.0002.exr is read" in held["text"]
    assert (1, "plate", f"reads {shot.replace('####', '0001')}") in told[0]
    assert not any("nothing to do" in text for _, _, text in told[0])
    assert (1, None, "nothing to do: its files are there, whole, and made from the same") in told[1]
