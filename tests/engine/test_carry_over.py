"""Runs of nodes that read other frames: each result is computed once, little is held, and no order changes anything."""

import gc
import random
import weakref
from collections import Counter

import numpy as np
import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_frame import render_frame
from flowabs_nodes.engine.render_sequence import render_sequence
from flowabs_nodes.engine.result_store import ResultStore
from flowabs_nodes.errors import FlowabsError
from tests.engine.sequences import pixels, plates, statuses
from tests.engine.windows import MEAN, asking, chain, counting, grey_plate, greys, load, node

FRAMES = 48
PICTURE = 48 * 64 * 3 * 4


@pytest.fixture
def calls():
    """Count the calls of nodes of the type ``count``, by node and frame."""
    return Counter()


@pytest.fixture
def store():
    return ResultStore()


@pytest.fixture(scope="module")
def shot(tmp_path_factory):
    """Write 48 plates and return their pattern."""
    return plates(tmp_path_factory.mktemp("in"), *range(1, FRAMES + 1))


def run(graph, out, store=None, **options):
    return render_sequence(graph, RunOptions(output=str(out / "out.####.exr"), **options), store=store)


def pictures(out):
    return {path.name: pixels(path) for path in sorted(out.glob("*.exr"))}


def same(a, b):
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)


# ---------------------------------------------------------------------- a long run


def test_each_result_is_computed_once_in_a_run_and_little_is_held(shot, calls, store, tmp_path):
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    assert run(graph, tmp_path, store).exit_code == 0
    assert calls == {("count", frame): 1 for frame in range(1, FRAMES + 1)}
    assert store.peak_bytes == 4 * PICTURE, "the two frames before the next one's own, and two after"
    assert store.bytes == 0


def test_memory_is_flat(shot, tmp_path, quick_collection):
    seen, alive = [], []

    def watch(context, image, *, radius):
        gc.collect()
        seen.extend(weakref.ref(each) for each in image.values())
        alive.append(len({id(each()) for each in seen if each() is not None}))
        return MEAN.run(context, image, radius=radius)

    run(load(chain("mean", plate={"file": shot}), asking(MEAN.frames, watch)), tmp_path, frames="1-20")
    assert max(alive) <= 2 * 5, "the window, and what the store holds of it"
    assert max(alive[10:]) == max(alive[5:10])


def test_a_graph_without_such_nodes_holds_nothing(shot, calls, store, tmp_path):
    run(load(chain("count", plate={"file": shot}), counting(calls)), tmp_path, store, frames="1-4")
    assert store.peak_bytes == 0


def test_along_a_chain_each_result_is_computed_once(shot, calls, store, tmp_path):
    nodes = chain("count_1", "mean_1", "count_2", "mean_2", plate={"file": shot}, mean_2={"radius": 1})
    run(load(nodes, MEAN, counting(calls)), tmp_path, store)
    assert calls == {(name, frame): 1 for name in ("count_1", "count_2") for frame in range(1, FRAMES + 1)}
    # Two results of count_2; of count_1 the four that the next of count_2 reads beside a new one.
    assert store.peak_bytes == (2 + 4) * PICTURE


def test_what_a_frame_reads_beside_the_window_is_computed_once_too(shot, calls, store, tmp_path):
    nodes = chain("count_1", "count_2", "mean", plate={"file": shot})
    nodes["out"]["inputs"]["plain"] = "count_1"
    run(load(nodes, MEAN, counting(calls)), tmp_path, store, frames="1-12")
    assert set(calls.values()) == {1}
    # Four of count_2; of count_1 the two that were needed for count_2 already and will be written.
    assert store.peak_bytes == (4 + 2) * PICTURE


def test_every_second_frame_and_backwards(shot, calls, store, tmp_path):
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    run(graph, tmp_path / "twos", store, frames="20-1x2")
    assert calls == {("count", frame): 1 for frame in range(1, 23)}
    assert store.peak_bytes == 3 * PICTURE


def test_frames_far_apart_hold_nothing(shot, calls, store, tmp_path):
    run(load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls)), tmp_path, store, frames="5,40,20")
    assert store.peak_bytes == 0


# ---------------------------------------------------------------------- the same, however it is computed


def test_a_frame_is_the_same_alone_in_a_run_and_in_another_order(shot, tmp_path):
    nodes = chain("blur", "mean_1", "mean_2", plate={"file": shot})
    nodes["lines"] = node("etf", "mean_1")
    nodes["out"]["inputs"]["flow"] = "lines"
    graph = load(nodes, MEAN)
    frames = list(range(1, 12))
    run(graph, tmp_path / "run", frames=frames)
    shuffled = random.Random(1).sample(frames, len(frames))
    run(graph, tmp_path / "shuffled", frames=shuffled)
    job, _ = build_job(graph, RunOptions(output=str(tmp_path / "alone/out.####.exr"), frames=frames))
    for frame in frames:
        assert render_frame(job, frame).status == "done"
    run(graph, tmp_path / "tight", ResultStore(3 * PICTURE), frames=frames)
    expected = pictures(tmp_path / "run")
    assert len(expected) == 11
    for other in ("shuffled", "alone", "tight"):
        assert same(pictures(tmp_path / other), expected)
    in_python = graph.run(5, outputs=["mean_2"])["mean_2"].pixels
    assert np.array_equal(in_python, expected["out.0005.exr"][..., :3])


def test_any_order_computes_each_result_once(shot, calls, store, tmp_path):
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    run(graph, tmp_path, store, frames="10,1,5,30,12,3,11,2,4")
    assert calls == {("count", frame): 1 for frame in (*range(1, 15), *range(28, 33))}
    assert store.bytes == 0


@pytest.mark.parametrize("pictures_held", [0, 1, 3])
def test_too_small_a_store_computes_again_and_stays_in_its_bound(shot, calls, tmp_path, pictures_held):
    store = ResultStore(pictures_held * PICTURE + 100)
    run(load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls)), tmp_path, store, frames="1-12")
    assert store.peak_bytes == pictures_held * PICTURE
    most = {0: 5, 1: 5, 3: 2}[pictures_held]
    assert 1 < max(calls.values()) <= most


def test_a_node_that_looks_at_the_frames_number_is_not_mistaken_for_another_frames(tmp_path, store):
    def stamp(context, image, *, gain):
        return image.with_pixels(image.pixels * 0 + np.float32(context.frame))

    stamping = counting(Counter())
    stamping = type(stamping)("count", 1, ".", stamping.inputs, stamping.outputs, stamping.params, stamp)
    greys(tmp_path / "in", 1, 5)
    shot = str(tmp_path / "in/plate.####.exr")  # frames 2 to 4 are the first one, held
    graph = load(chain("count", "mean", plate={"file": shot, "missing": "hold"}), MEAN, stamping)
    run(graph, tmp_path, store, frames="1-5")
    found = [pixels(tmp_path / f"out.{frame:04d}.exr").max() for frame in range(1, 6)]
    assert found == [2, 2.5, 3, 3.5, 4]


def test_what_changes_from_frame_to_frame_is_not_kept_for_nothing(shot, calls, store, tmp_path):
    nodes = chain("count", "mean", plate={"file": shot})
    nodes["mean"]["params"]["radius"] = {"curve": {"8": 0, "10": 2}}
    run(load(nodes, MEAN, counting(calls)), tmp_path, store, frames="1-7")
    assert store.peak_bytes == 0
    run(load(nodes, MEAN, counting(calls)), tmp_path, store, frames="8-12")
    assert set(calls.values()) == {1}


# ---------------------------------------------------------------------- what goes wrong on the way


def test_a_frame_that_fails_keeps_what_it_computed_for_the_others(shot, calls, store, tmp_path):
    def run_mean(context, image, *, radius):
        if context.frame == 3:
            raise FlowabsError("no")
        return image[0]

    graph = load(chain("count", "mean", plate={"file": shot}), asking(MEAN.frames, run_mean), counting(calls))
    report = run(graph, tmp_path, store, frames="1-6")
    assert [status for _, status in statuses(report)] == ["done", "done", "failed", "done", "done", "done"]
    assert set(calls.values()) == {1}
    assert store.bytes == 0


def test_a_frame_whose_frames_are_wrong_disturbs_no_other(shot, calls, store, tmp_path):
    def frames(params):
        return {"image": (1,) if params["radius"] == 1 else (-1, 0, 1)}

    nodes = chain("count", "mean", plate={"file": shot})
    nodes["mean"]["params"]["radius"] = {"curve": {"2": 0, "3": 1, "4": 2}}
    report = run(load(nodes, asking(frames), counting(calls)), tmp_path, store, frames="1-6")
    assert [frame for frame, status in statuses(report) if status == "failed"] == [3]
    assert set(calls.values()) == {1}


# ---------------------------------------------------------------------- resume


def test_a_changed_plate_redoes_the_frames_around_it_and_no_other(tmp_path, calls, store):
    shot = greys(tmp_path / "in", *range(1, 13))
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    run(graph, tmp_path)
    assert {status for _, status in statuses(run(graph, tmp_path))} == {"skipped"}
    grey_plate(tmp_path / "in/plate.0006.exr", 0.5)
    calls.clear()
    again = statuses(run(graph, tmp_path, store))
    assert [frame for frame, status in again if status == "done"] == [4, 5, 6, 7, 8]
    assert calls == {("count", frame): 1 for frame in range(2, 11)}
    assert store.bytes == 0
    (tmp_path / "in/plate.0012.exr").unlink()
    again = statuses(run(graph, tmp_path))
    assert [frame for frame, status in again if status == "done"] == [10, 11]


def test_frames_done_in_between_are_skipped_and_nothing_is_computed_twice(tmp_path, calls, store):
    shot = greys(tmp_path / "in", *range(1, 13))
    nodes = chain("count_1", "mean_1", "count_2", "mean_2", plate={"file": shot}, mean_2={"radius": 1})
    nodes["out"]["inputs"]["plain"] = "count_1"
    graph = load(nodes, MEAN, counting(calls))
    run(graph, tmp_path)
    for frame in (3, 6, 7):
        (tmp_path / f"out.{frame:04d}.exr").unlink()
    calls.clear()
    assert [frame for frame, status in statuses(run(graph, tmp_path, store)) if status == "done"] == [3, 6, 7]
    assert set(calls.values()) == {1}


# ---------------------------------------------------------------------- a store that outlives the run


def test_a_session_may_keep_everything(shot, calls, tmp_path):
    store = ResultStore(keeps_all=True)
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    run(graph, tmp_path, store, frames="1-6")
    assert store.peak_bytes == store.bytes > 8 * PICTURE
    run(graph, tmp_path, store, frames="1-6", existing="overwrite")
    assert set(calls.values()) == {1}
    run(graph.with_set({"count.gain": 2.0}), tmp_path, store, frames="3", existing="overwrite")
    assert Counter(calls.values()) == {2: 5, 1: 3}


def test_a_session_keeps_no_more_than_its_bound(shot, calls, tmp_path):
    store = ResultStore(5 * PICTURE, keeps_all=True)
    run(load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls)), tmp_path, store, frames="1-6")
    assert store.peak_bytes == 5 * PICTURE


# ---------------------------------------------------------------------- notes


@pytest.mark.parametrize("held", [0, 100])
def test_what_a_node_says_about_a_frame_is_told_once(shot, calls, tmp_path, held):
    events = []
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    options = RunOptions(output=str(tmp_path / "out.####.exr"), frames="5-9")
    render_sequence(graph, options, on_event=events.append, store=ResultStore(held * PICTURE))
    told = [(each["frame"], each["text"]) for each in events if each["event"] == "note" and each["node"] == "count"]
    assert sorted(told) == [(frame, f"seen {frame}") for frame in range(3, 12)]


def test_graph_run_tells_each_frames_notes_under_its_own_number(shot, calls):
    events = []
    graph = load(chain("count", "mean", plate={"file": shot}), MEAN, counting(calls))
    graph.run(5, on_event=events.append)
    assert [each["frame"] for each in events if each["node"] == "count"] == [3, 4, 5, 6, 7]


def test_the_files_of_other_frames_are_not_claimed(shot, tmp_path):
    from flowabs_nodes.io.claim import claim

    graph = load(chain("mean", plate={"file": shot}), MEAN)
    (tmp_path / "out.0004.exr").parent.mkdir(exist_ok=True)
    with claim(str(tmp_path / "out.0004.exr")):
        report = engine.run(graph, output=str(tmp_path / "out.####.exr"), frames="3,5")
    assert statuses(report) == [(3, "done"), (5, "done")]
