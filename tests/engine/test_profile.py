"""Seconds by node: how many frames a node ran on, and how often."""

from collections import Counter

import pytest

from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.profile import NodeTime, total_times
from flowabs_nodes.engine.render_sequence import render_sequence
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.engine.stopwatch import Timing
from tests.engine.sequences import plates, run
from tests.engine.windows import MEAN, chain, counting, load


def test_frames_are_counted_once_and_runs_each():
    timings = [Timing("flow", 1, 1.0), Timing("flow", 2, 2.0), Timing("flow", 1, 3.0), Timing("out", 1, 0.5)]
    assert total_times(timings, {"flow": "etf"}) == (
        NodeTime("flow", "etf", 2, 6.0, 3.0, 3),
        NodeTime("out", "", 1, 0.5, 0.5, 1),
    )


def test_nothing_took_no_time():
    assert total_times((), {}) == ()


def test_a_profile_of_a_run_adds_up(tmp_path):
    report = run(plates(tmp_path / "in", 1, 2, 3), tmp_path / "out.####.exr", profile=True)
    times = {time.node: time for time in report.profile}
    assert {name: (time.frames, time.runs) for name, time in times.items()} == {
        "plate": (3, 3),
        "bright": (3, 3),
        "out": (3, 3),
        "(keys)": (3, 3),
    }
    assert sum(time.seconds for time in report.profile) == pytest.approx(
        sum(timing.seconds for frame in report.frames for timing in frame.timings)
    )


@pytest.mark.parametrize(("held", "runs"), [(100, 7), (0, 15)])
def test_a_node_is_counted_on_every_frame_that_it_ran_on(tmp_path, held, runs):
    calls = Counter()
    shot = plates(tmp_path / "in", *range(1, 11))
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    options = RunOptions(output=str(tmp_path / "out.####.exr"), frames="4-6")
    report = render_sequence(graph, options, profile=True, store=ResultStore(held * 48 * 64 * 3 * 4))
    times = {time.node: (time.frames, time.runs) for time in report.profile}
    assert times["count"] == (7, runs) == (len(calls), sum(calls.values()))
    assert times["mean"] == times["out"] == (3, 3)


def test_what_was_noted_down_and_done_later_has_a_name_of_its_own(tmp_path):
    plate = plates(tmp_path / "in", 1).replace("####", "0001")
    nodes = {
        "plate": {"type": "read@1", "params": {"file": plate}},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "smooth": {"type": "fbl@1", "inputs": {"image": "plate", "flow": "flow"}},
        "flat": {"type": "quantize@1", "inputs": {"image": "smooth"}},
        "out": {"type": "write@1", "inputs": {"image": "flat"}},
        "plain": {"type": "write@1", "inputs": {"image": "smooth"}, "params": {"file": str(tmp_path / "plain.exr")}},
    }
    nodes["out"]["params"] = {"file": str(tmp_path / "flat.exr")}
    report = render_sequence(load(nodes), RunOptions(), profile=True)
    assert report.exit_code == 0
    assert {"(finishing flat)", "(decoding smooth)"} <= {time.node for time in report.profile}
