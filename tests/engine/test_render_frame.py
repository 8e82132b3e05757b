"""One frame of a run: what is skipped, what is rendered again, and what becomes of frames that cannot be."""

import json
import pickle

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine import evaluate as evaluate_module
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_frame import render_frame
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.claim_files import HOST
from tests.engine.sequences import (
    codes,
    document,
    leftovers,
    pixels,
    plate,
    plates,
    raising,
    run,
    statuses,
)


def test_a_frame_can_be_made_by_another_process(shot, out):
    graph = engine.load_graph(document())
    job, frames = build_job(graph, RunOptions(input=shot, output=out))
    again = pickle.loads(pickle.dumps(job))
    report = pickle.loads(pickle.dumps(render_frame(again, frames[0])))
    assert report.status == "done"
    assert render_frame(job, frames[0]).status == "skipped"


def test_a_frame_that_another_run_has_claimed_is_refused_before_any_filtering(shot, out):
    job, _ = build_job(engine.load_graph(document()), RunOptions(input=shot, output=out))
    with claim(out.replace("####", "0002")):
        report = render_frame(job, 2)
    assert report.error.code == "claimed"
    assert f"being written by another run, on {HOST}" in str(report.error)
    assert [timing.work for timing in report.timings] == ["(keys)"], "no node ran"
    assert render_frame(job, 2).status == "done"


def test_a_frame_is_claimed_while_its_nodes_run(shot, out, tmp_path, monkeypatch):
    seen = []

    def looks(*arguments, **options):
        seen.append(leftovers(tmp_path))
        return call_node(*arguments, **options)

    monkeypatch.setattr(evaluate_module, "call_node", looks)
    run(shot, out, frames=2)
    assert seen
    assert all([path.name.startswith(".toon.0002.exr.") for path in found] == [True, True] for found in seen)
    assert not leftovers(tmp_path)


# ---------------------------------------------------------------------- files that are there already


def test_a_second_run_skips_what_is_there(shot, out):
    run(shot, out)
    report = run(shot, out)
    assert statuses(report) == [(1, "skipped"), (2, "skipped"), (3, "skipped")]
    assert report.exit_code == 0


def test_what_changed_is_made_again_and_nothing_else(shot, out, tmp_path):
    run(shot, out)
    assert statuses(run(shot, out, set={"stops": 2.0}, frames="1"))[0] == (1, "done")
    (tmp_path / "out/toon.0002.exr").unlink()
    assert statuses(run(shot, out)) == [(1, "done"), (2, "done"), (3, "skipped")]
    plate(tmp_path / "in/plate.0003.exr", seed=99)
    assert statuses(run(shot, out)) == [(1, "skipped"), (2, "skipped"), (3, "done")]


def test_moving_everything_changes_nothing(shot, out, tmp_path):
    run(shot, out)
    (tmp_path / "in").rename(tmp_path / "elsewhere")
    (tmp_path / "out").rename(tmp_path / "there")
    report = run(tmp_path / "elsewhere/plate.####.exr", tmp_path / "there/toon.####.exr")
    assert {frame.status for frame in report.frames} == {"skipped"}


def test_a_file_holds_the_graph_that_made_it(shot, out, tmp_path):
    run(shot, out, set={"stops": 0.5}, frames=1)
    stored = oiio.ImageBuf(out.replace("####", "0001")).spec().get("flowabs:graph")
    again = engine.run(json.loads(stored), frames=1)
    assert statuses(again) == [(1, "skipped")]


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_damaged_file_of_ours_is_made_again(shot, out, tmp_path, share):
    run(shot, out)
    victim = tmp_path / "out/toon.0002.exr"
    whole = victim.read_bytes()
    victim.write_bytes(whole[: int(len(whole) * share)])
    report = run(shot, out)
    assert statuses(report) == [(1, "skipped"), (2, "done"), (3, "skipped")]
    assert any("damaged" in note.text for note in report.frames[1].notes)
    assert victim.read_bytes() == whole


def test_a_file_that_is_not_ours_is_left_alone(shot, out, tmp_path):
    foreign = plate(tmp_path / "out/toon.0002.exr", seed=5)
    before = foreign.read_bytes()
    report = run(shot, out)
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert codes(report) == {2: "foreign-file"}
    assert report.exit_code == 1
    assert str(foreign) in str(report.frames[1].error)
    assert foreign.read_bytes() == before
    assert statuses(run(shot, out, existing="overwrite")) == [(1, "done"), (2, "done"), (3, "done")]


def test_existing_error(shot, out):
    run(shot, out, frames=2)
    report = run(shot, out, existing="error")
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert codes(report) == {2: "exists"}


# ---------------------------------------------------------------------- frames that are missing or fail


@pytest.mark.parametrize(
    ("policy", "status", "source"),
    [
        ("error", "failed", None),
        ("skip", "skipped", None),
        ("hold", "done", 1),
        ("nearest", "done", 3),
        ("black", "done", 0),
    ],
)
def test_missing_frames(tmp_path, out, policy, status, source):
    shot = plates(tmp_path / "in", 1, 4)
    (tmp_path / "in/plate.0004.exr").rename(tmp_path / "in/plate.0003.exr")
    (tmp_path / "in/plate.0001.exr").rename(tmp_path / "in/plate.0000.exr")
    source = {1: 0, 3: 3, 0: "black"}.get(source)
    by_node = document(plate={"type": "read@1", "params": {"missing": policy}})
    for options in ({"missing": policy}, {"graph": by_node, "existing": "overwrite"}):
        report = run(shot, out, frames="2", **options)
        assert statuses(report) == [(2, status)]
        assert report.exit_code == (1 if status == "failed" else 0)
        made = tmp_path / "out/toon.0002.exr"
        assert made.exists() == (status == "done")
        assert report.frames[0].files == (() if status == "skipped" else (str(made),))
        if source == "black":
            assert pixels(made).shape == (48, 64, 3)
            assert not pixels(made).any()
        elif source is not None:
            np.testing.assert_allclose(pixels(made), 2 * pixels(tmp_path / f"in/plate.{source:04d}.exr"), rtol=1e-3)


def test_a_missing_frame_says_which(tmp_path, out):
    report = run(plates(tmp_path / "in", 1), out, frames="1-2")
    assert codes(report) == {2: "missing-file"}
    error = report.frames[1].error
    assert (error.frame, error.node, error.file) == (2, "plate", str(tmp_path / "in/plate.0002.exr"))


@pytest.mark.parametrize("how", ["empty", "text", "truncated"])
def test_a_bad_frame_stops_no_other(shot, out, tmp_path, how):
    bad = tmp_path / "in/plate.0002.exr"
    whole = bad.read_bytes()
    bad.write_bytes({"empty": b"", "text": b"hello", "truncated": whole[: len(whole) // 2]}[how])
    report = run(shot, out)
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert report.exit_code == 1
    error = report.frames[1].error
    assert (error.frame, error.node, error.file) == (2, "plate", str(bad))
    assert not (tmp_path / "out/toon.0002.exr").exists()
    assert not leftovers(tmp_path)


def test_a_frame_that_is_missing_in_one_of_two_plates_is_not_hidden(tmp_path):
    two = document(
        other={"type": "read@1", "params": {"file": plates(tmp_path / "b", 1)}},
        plate={"type": "read@1", "params": {"file": plates(tmp_path / "a", 1, 2)}},
        out={"type": "write@1", "inputs": {"image": "bright", "other": "other"}},
    )
    report = engine.run(two, output=tmp_path / "out.####.exr")
    assert statuses(report) == [(1, "done"), (2, "failed")]


@pytest.mark.parametrize(
    ("error", "code"),
    [(MemoryError(), "out-of-memory"), (ZeroDivisionError("oh"), "internal"), (CommandError("no"), "bad-command")],
)
def test_whatever_a_node_raises_fails_its_frame_alone(shot, out, tmp_path, error, code):
    report = run(shot, out, raising(error))
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert codes(report) == {2: code}
    assert (report.frames[1].error.node, report.frames[1].error.frame) == ("bright", 2)
    assert not (tmp_path / "out/toon.0002.exr").exists()
