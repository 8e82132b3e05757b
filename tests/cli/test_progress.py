"""What a run shows, with the engine played by a stand-in."""

import json

import pytest

from flowabs_nodes.cli.progress import JsonLines, Lines, Loudness


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
        "1 frame failed:",
        "  frame 1002: is cut short",
        "To make just these again:",
        "  flowabs run lines --frames 1002",
    ]


def test_a_profile_shows_seconds_and_shares(flowabs, fake_run):
    table = flowabs("run", "lines", "--profile")[1].splitlines()[-3:]
    assert table[0].split() == ["node", "type", "frames", "seconds", "share", "a", "frame", "longest"]
    assert table[1].split() == ["flow", "etf", "2", "3.000", "75.0%", "1.500", "2.000"]
    assert table[2].split() == ["lines", "fdog", "2", "1.000", "25.0%", "0.500", "0.500"]
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
    assert [(row["node"], row["frames"], row["runs"]) for row in events[-1]["nodes"]] == [
        ("flow", 2, 2),
        ("lines", 2, 3),
    ]
    assert "is cut short" in err


def test_quiet_says_failures_and_warnings_only(flowabs, fake_run):
    loud = flowabs("run", "lines")[2]
    code, out, err = flowabs("run", "lines", "-q")
    assert (code, out) == (1, "")
    assert err == loud.replace("run lines", "run lines -q")


def test_quiet_json_has_the_frames_and_no_notes(flowabs, fake_run):
    events = [json.loads(line) for line in flowabs("run", "lines", "-q", "--json")[1].splitlines()]
    assert [each["event"] for each in events] == ["start", "note", "frame", "frame", "end"]
    assert events[1]["level"] == "warning"


def test_quiet_and_verbose_exclude_each_other(flowabs, fake_run):
    code, out, err = flowabs("run", "lines", "-q", "-v")
    assert (code, out) == (2, "")
    assert "-v says more and -q says less" in err
    assert not fake_run


NODE = {"event": "node", "frame": 3, "node": "flow", "type": "etf", "status": "done", "seconds": 1.5, "progress": 0.5}
EVENTS = [
    {"event": "start", "graph": "toon", "frames": 2},
    NODE | {"status": "started", "seconds": None},
    NODE,
    {"event": "detail", "frame": 3, "node": "plate", "text": "reads in.0003.exr"},
    {"event": "profile", "frame": 3, "nodes": []},
    {"event": "shared-note", "frames": "1-24", "count": 24, "node": "plate", "level": "note", "text": "linear"},
]


@pytest.mark.parametrize(
    ("loudness", "lines"),
    [
        (Loudness.QUIET, []),
        (Loudness.NORMAL, []),
        (
            Loudness.VERBOSE,
            ["frame 3  flow: etf 1.50 s", "frame 3  plate: reads in.0003.exr", "frames 1-24: plate: linear"],
        ),
    ],
)
def test_what_is_said_by_loudness(capsys, loudness, lines):
    view = Lines(loudness, str)
    for event in EVENTS:
        view.event(event)
    assert capsys.readouterr().out.splitlines() == lines


def test_json_has_node_events_and_details_only_if_verbose(capsys):
    for loudness, kinds in (
        (Loudness.NORMAL, ["start", "node", "node", "profile", "shared-note"]),
        (Loudness.VERBOSE, ["start", "node", "node", "detail", "profile", "shared-note"]),
    ):
        view = JsonLines(loudness, str)
        for event in EVENTS:
            view.event(event)
        assert [json.loads(line)["event"] for line in capsys.readouterr().out.splitlines()] == kinds


def test_a_name_with_a_newline_stays_on_its_line(capsys):
    name = "a\nframe 2  done.exr"
    Lines(Loudness.NORMAL, str).frame({"frame": 1, "status": "done", "seconds": 0.0, "files": [name]})
    assert len(capsys.readouterr().out.splitlines()) == 1
