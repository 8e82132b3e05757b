"""What a run shows, with the engine played by a stand-in."""

import json
import re

from flowabs_nodes.cli import progress


def test_a_log_has_a_line_a_frame(flowabs, fake_run):
    code, out, err = flowabs("run", "lines")
    assert code == 1
    assert out.splitlines() == [
        "soft: fbl@1 read as fbl@2",
        "frame 1001  flow: gradient reference max = 83.2",
        "frame 1001  done       1.25 s  out.1001.exr, out.1001.png",
        "1 done, 1 failed in 2.00 s",
    ]
    assert err.splitlines() == [
        "frame 1001  warning: out: clipped",
        "frame 1002  failed  in.1002.exr: is cut short",
    ]


def test_a_profile_shows_seconds_and_shares(flowabs, fake_run):
    table = flowabs("run", "lines", "--profile")[1].splitlines()[-3:]
    assert table[0].split() == ["node", "type", "seconds", "share", "a", "frame", "longest"]
    assert table[1].split() == ["flow", "etf", "3.000", "75.0%", "1.500", "2.000"]
    assert table[2].split() == ["lines", "fdog", "1.000", "25.0%", "0.500", "0.500"]
    assert len({len(line) for line in table}) == 1


def test_json_is_an_event_a_line(flowabs, fake_run):
    code, out, err = flowabs("run", "lines", "--json", "--profile")
    assert code == 1
    events = [json.loads(line) for line in out.splitlines()]
    kinds = ["start", "note", "note", "note", "frame", "frame", "end", "profile"]
    assert [event["event"] for event in events] == kinds
    done, failed = events[4:6]
    assert (done["frame"], done["status"], done["file"], done["seconds"], done["error"]) == (
        1001,
        "done",
        "out.1001.exr",
        1.25,
        None,
    )
    assert failed["error"]["code"] == "read-failed"
    assert events[-1]["nodes"][0]["node"] == "flow"
    assert "is cut short" in err


def test_a_terminal_has_a_bar(flowabs, fake_run, monkeypatch):
    monkeypatch.setattr(progress, "on_a_terminal", lambda: True)
    code, out, err = flowabs("run", "lines")
    assert code == 1
    assert "2/2" in err
    assert re.search(r"\d (frames/s|s/ frames)|\? *frames/s", err), "frames a second"
    assert re.search(r"<\d\d:\d\d|<\?", err), "time left"
    assert "is cut short" in err
    assert "gradient reference" in out
    assert "1 done, 1 failed" in out
