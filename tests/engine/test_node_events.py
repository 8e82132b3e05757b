"""Which node is at work, and how far its frame is."""

import pytest

from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.plan import Step, Unit
from tests.engine.sequences import plates, raising, run

TYPES = {"plate": "read", "flow": "etf", "out": "write"}
STEPS = [Step(Unit(name, 1), {}, frozenset(), frozenset()) for name in TYPES]


@pytest.fixture
def events():
    return []


@pytest.fixture
def nodes(events):
    return NodeEvents(events.append, TYPES)


def render(nodes, frame, **seconds):
    """Tell of a frame whose nodes take so many seconds."""
    nodes.begin_frame(frame)
    nodes.begins("(keys)")
    nodes.ends("(keys)", 0.5)
    nodes.plan(STEPS)
    for name, each in seconds.items():
        nodes.begins(name)
        nodes.ends(name, each)


def test_on_the_first_frame_all_nodes_count_the_same(nodes, events):
    render(nodes, 7, plate=1.0, flow=8.0, out=1.0)
    assert [(each["node"], each["type"], each["status"]) for each in events[:4]] == [
        ("(keys)", "", "started"),
        ("(keys)", "", "done"),
        ("plate", "read", "started"),
        ("plate", "read", "done"),
    ]
    assert [each["progress"] for each in events if each["status"] == "done"] == pytest.approx(
        [0, 1 / 3, 2 / 3, 1], abs=1e-4
    )
    assert {each["frame"] for each in events} == {7}
    assert events[5]["seconds"] == 8.0
    assert events[4]["seconds"] is None


def test_later_they_count_by_what_they_took_at_best(nodes, events):
    render(nodes, 1, plate=1.0, flow=80.0, out=1.0)
    render(nodes, 2, plate=1.0, flow=8.0, out=2.0)
    events.clear()
    render(nodes, 3, plate=5.0, flow=5.0, out=5.0)
    assert [each["progress"] for each in events if each["status"] == "done"] == pytest.approx([0, 0.1, 0.9, 1])


def test_work_inside_of_a_node_moves_nothing(nodes, events):
    nodes.begin_frame(1)
    nodes.plan(STEPS)
    nodes.begins("out")
    nodes.begins("(finishing flow)")
    nodes.ends("(finishing flow)", 3.0)
    assert events[-1]["progress"] == 0
    nodes.ends("out", 4.0)
    assert events[-1]["progress"] == pytest.approx(1 / 3, abs=1e-4)


def test_a_node_on_several_frames_counts_each_time(nodes, events):
    nodes.begin_frame(2)
    nodes.plan([Step(Unit("plate", frame), {}, frozenset(), frozenset()) for frame in (1, 2, 3)])
    for _ in range(3):
        nodes.begins("plate")
        nodes.ends("plate", 1.0)
    assert [each["progress"] for each in events[1::2]] == pytest.approx([1 / 3, 2 / 3, 1], abs=1e-4)


# ---------------------------------------------------------------------- whole runs


def test_a_run_tells_of_each_node_and_of_its_own_progress(tmp_path, events):
    run(plates(tmp_path / "in", 1, 2), tmp_path / "out.####.exr", on_event=events.append)
    told = [each for each in events if each["event"] == "node"]
    for frame in (1, 2):
        mine = [(each["node"], each["status"]) for each in told if each["frame"] == frame]
        names = ("(keys)", "plate", "bright", "out")
        assert mine == [(name, status) for name in names for status in ("started", "done")]
    percents = [each["percent"] for each in events if "percent" in each]
    assert percents == sorted(percents)
    assert (percents[0], percents[-1]) == (0, 100)
    assert [each["percent"] for each in events if each["event"] == "frame"] == [50, 100]


def test_a_node_that_fails_has_an_end_too(tmp_path, events):
    run(plates(tmp_path / "in", 1, 2, 3), tmp_path / "out.####.exr", raising(ValueError("no")), on_event=events.append)
    told = [each for each in events if each["event"] == "node" and each["frame"] == 2]
    assert (told[-1]["node"], told[-1]["status"]) == ("bright", "done")
    assert [each["percent"] for each in events if each["event"] == "frame"] == pytest.approx([33.33, 66.67, 100])


def test_nobody_is_told_where_nobody_listens(tmp_path, monkeypatch):
    def never(*_):
        raise AssertionError("an event was made")

    monkeypatch.setattr(NodeEvents, "_tell", never)
    assert run(plates(tmp_path / "in", 1), tmp_path / "out.####.exr").exit_code == 0
