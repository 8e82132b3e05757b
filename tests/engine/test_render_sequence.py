"""Whole runs, from EXR files to EXR files."""

import json
import os
import pickle
import signal
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine import evaluate as evaluate_module
from flowabs_nodes.engine import render_frame as frame_module
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_frame import render_frame
from flowabs_nodes.engine.signals import stop_on_signals
from flowabs_nodes.errors import CommandError, FlowabsError, WriteError
from flowabs_nodes.io.frame_lock import HOST, claim
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Param
from tests.engine.sequences import document, graph_around, pixels, plate, plates


@pytest.fixture
def shot(tmp_path):
    return plates(tmp_path / "in", 1, 2, 3)


@pytest.fixture
def out(tmp_path):
    return str(tmp_path / "out" / "toon.####.exr")


def run(shot, out, graph=None, **options):
    return engine.run(graph or document(), input=shot, output=out, **options)


def statuses(report):
    return [(frame.frame, frame.status) for frame in report.frames]


def codes(report):
    return {frame.frame: frame.error.code for frame in report.frames if frame.error}


def leftovers(tmp_path):
    return [path for path in tmp_path.rglob("*") if path.name.endswith(".tmp")]


def test_every_frame_on_disk_is_made(shot, out, tmp_path):
    report = run(shot, out)
    assert statuses(report) == [(1, "done"), (2, "done"), (3, "done")]
    assert report.exit_code == 0
    for frame in (1, 2, 3):
        made = pixels(tmp_path / f"out/toon.{frame:04d}.exr")
        np.testing.assert_allclose(made, 2 * pixels(tmp_path / f"in/plate.{frame:04d}.exr"), rtol=1e-3)
    assert not leftovers(tmp_path)


def test_a_single_picture_is_frame_one(tmp_path):
    report = run(plate(tmp_path / "a.exr"), tmp_path / "b.exr")
    assert statuses(report) == [(1, "done")]
    assert report.frames[0].files == (str(tmp_path / "b.exr"),)


def test_a_frame_that_another_run_has_claimed_is_refused_before_any_filtering(shot, out):
    with claim(out.replace("####", "0002")):
        report = run(shot, out)
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert codes(report) == {2: "claimed"}
    assert f"being written by {HOST}" in str(report.frames[1].error)
    assert set(report.frames[1].timings) == {"(keys)"}, "no node ran"
    assert report.exit_code == 1
    assert statuses(run(shot, out)) == [(1, "skipped"), (2, "done"), (3, "skipped")]


def test_a_frame_is_claimed_while_its_nodes_run(shot, out, tmp_path, monkeypatch):
    seen = []

    def looks(*arguments, **options):
        seen.append(leftovers(tmp_path))
        return call_node(*arguments, **options)

    monkeypatch.setattr(evaluate_module, "call_node", looks)
    run(shot, out, frames=2)
    assert seen
    assert all([path.name.startswith(".toon.0002.exr.") for path in found] == [True] for found in seen)
    assert not leftovers(tmp_path)


def test_events(shot, out):
    events = []
    run(shot, out, frames="2-3", on_event=events.append)
    assert events == json.loads(json.dumps(events))
    assert events[0] == {"event": "start", "graph": "bright", "frames": 2}
    done = [event for event in events if event["event"] == "frame"]
    assert [(event["frame"], event["status"], event["error"]) for event in done] == [
        (2, "done", None),
        (3, "done", None),
    ]
    assert done[0]["file"] == out.replace("####", "0002")
    assert done[0]["seconds"] > 0
    assert {event["level"] for event in events if event["event"] == "note"} == {"note"}
    assert {name: events[-1][name] for name in ("event", "done", "skipped", "failed", "exit_code")} == {
        "event": "end",
        "done": 2,
        "skipped": 0,
        "failed": 0,
        "exit_code": 0,
    }


def test_each_further_output_has_the_same_image_in_its_own_format(shot, out, tmp_path):
    report = run(shot, [out, tmp_path / "look.####.png"], frames=1)
    assert report.frames[0].files == (out.replace("####", "0001"), str(tmp_path / "look.0001.png"))
    assert oiio.ImageBuf(str(tmp_path / "look.0001.png")).file_format_name == "png"
    (tmp_path / "look.0001.png").unlink()
    assert statuses(run(shot, [out, tmp_path / "look.####.png"], frames=1)) == [(1, "done")]
    assert (tmp_path / "look.0001.png").exists()


# ---------------------------------------------------------------------- what is there already


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
    assert statuses(run(shot, out, scale=0.5, frames=1)) == [(1, "done")]


def test_moving_everything_changes_nothing(shot, out, tmp_path):
    run(shot, out)
    (tmp_path / "in").rename(tmp_path / "elsewhere")
    (tmp_path / "out").rename(tmp_path / "there")
    report = run(tmp_path / "elsewhere/plate.####.exr", tmp_path / "there/toon.####.exr")
    assert {frame.status for frame in report.frames} == {"skipped"}


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


def trouble(error, on=2):
    """A graph that raises on one frame."""

    def run(context, image):
        if context.frame == on:
            raise error
        return image

    return graph_around(run)


@pytest.mark.parametrize(
    ("error", "code"),
    [(MemoryError(), "out-of-memory"), (ZeroDivisionError("oh"), "internal"), (CommandError("no"), "bad-command")],
)
def test_whatever_a_node_raises_fails_its_frame_alone(shot, out, tmp_path, error, code):
    report = run(shot, out, trouble(error))
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert codes(report) == {2: code}
    assert (report.frames[1].error.node, report.frames[1].error.frame) == ("bright", 2)
    assert not (tmp_path / "out/toon.0002.exr").exists()


def test_a_full_disk_stops_the_run(shot, out, monkeypatch):
    def full(*args, **options):
        raise WriteError("no space is left on the disk", code="disk-full")

    monkeypatch.setattr(frame_module, "save", full)
    events = []
    report = run(shot, out, on_event=events.append)
    assert statuses(report) == [(1, "failed"), (2, "failed"), (3, "failed")]
    assert report.exit_code == 1
    assert "not made" in str(report.frames[2].error)
    assert [event["frame"] for event in events if event["event"] == "frame"] == [1, 2, 3]


def test_an_interrupt_ends_the_run_in_good_order(shot, out, tmp_path):
    events = []
    report = run(shot, out, trouble(KeyboardInterrupt()), on_event=events.append)
    assert statuses(report) == [(1, "done")]
    assert report.exit_code == 130
    assert events[-1]["exit_code"] == 130
    assert not leftovers(tmp_path)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals(shot, out, number, code):
    def kill(context, image):
        os.kill(os.getpid(), number)
        return image

    before = signal.getsignal(number)
    with stop_on_signals():
        report = run(shot, out, graph_around(kill))
    assert report.exit_code == code
    assert signal.getsignal(number) is before


# ---------------------------------------------------------------------- what is refused before anything is written


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"output": None}, "file-not-set"),
        ({"input": None}, "file-not-set"),
        ({"output": "{tmp}/one.exr"}, "no-frame-token"),
        ({"output": ["{tmp}/a.####.exr", "{tmp}/a.####.exr"]}, "same-output"),
        ({"output": "{tmp}/in/plate.####.exr"}, "output-is-input"),
        ({"output": "{tmp}/in/../in/plate.%04d.exr"}, "output-is-input"),
        ({"output": "{tmp}/link.####.exr", "frames": "9"}, "output-is-input"),
        ({"output": "{tmp}/a.####.jpg"}, "bad-format"),
        ({"output": "{tmp}/in/plate.0001.exr/x.####.exr"}, "unwritable-folder"),
        ({"output": "/proc/1/nothing/x.####.exr"}, "unwritable-folder"),
        ({"frames": "1-"}, "bad-frames"),
        ({"frames": []}, "bad-frames"),
        ({"frames": [1, 2.5]}, "bad-frames"),
        ({"input": "{tmp}/none.####.exr"}, "no-frames"),
        ({"input": "{tmp}/in/plate.####.####.exr"}, "bad-sequence"),
        ({"existing": "keep"}, "bad-value"),
        ({"missing": "hole"}, "bad-value"),
        ({"scale": 0}, "bad-value"),
        ({"settings": Settings(root="{tmp}/in")}, "outside-root"),
        ({"settings": Settings(ocio="no/such.ocio")}, "bad-ocio-config"),
        ({"graph": "abstractoin"}, "unknown-graph"),
        ({"set": {"stop": 1}}, "bad-graph"),
    ],
)
def test_wrong_commands(shot, out, tmp_path, options, code):
    (tmp_path / "link.0009.exr").symlink_to(tmp_path / "in/plate.0002.exr")

    def placed(value):
        if isinstance(value, Settings):
            return replace(value, root=value.root and tmp_path / "in")
        if isinstance(value, list):
            return [placed(each) for each in value]
        return value.replace("{tmp}", str(tmp_path)) if isinstance(value, str) else value

    options = {"graph": document(), "input": shot, "output": out} | {
        name: placed(each) for name, each in options.items()
    }
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(FlowabsError) as failure:
        engine.run(options.pop("graph"), **options)
    assert failure.value.code == code
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("nodes", "option", "code"),
    [
        ({"second": {"type": "read@1"}}, "input", "several-reads"),
        ({"second": {"type": "write@1", "inputs": {"image": "plate"}}}, "output", "several-writes"),
    ],
)
def test_with_several_reads_or_writes_the_node_must_be_named(shot, nodes, option, code):
    with pytest.raises(CommandError, match=r"--set .*\.file=FILE") as failure:
        engine.run(document(**nodes), **{option: shot})
    assert failure.value.code == code


def test_a_graph_that_writes_nothing(shot):
    graph = document()
    del graph["nodes"]["out"]
    with pytest.raises(CommandError) as failure:
        engine.run(graph, input=shot)
    assert failure.value.code == "no-write"


def test_an_option_that_does_not_exist_is_refused(shot, out):
    with pytest.raises(TypeError, match="frame_range"):
        run(shot, out, frame_range="1-3")


def test_settings_may_be_given_in_one_object_or_each_by_itself(shot, out, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    for options in ({"settings": Settings(root=elsewhere)}, {"root": elsewhere}):
        with pytest.raises(CommandError) as failure:
            run(shot, out, **options)
        assert failure.value.code == "outside-root"
    assert run(shot, out, settings=Settings(root=elsewhere), root=tmp_path).exit_code == 0, "what is given itself wins"


def test_files_may_be_set_by_name(shot, out):
    assert run(None, None, set={"plate.file": shot, "out.file": out}, frames=1).exit_code == 0


# ---------------------------------------------------------------------- scale, profile, processes, memory


def test_scale_writes_a_smaller_picture(shot, out, tmp_path):
    assert run(shot, out, scale=0.5, frames=1).exit_code == 0
    assert pixels(tmp_path / "out/toon.0001.exr").shape == (24, 32, 3)
    assert pixels(tmp_path / "out/toon.0001.exr").mean() == pytest.approx(
        2 * pixels(tmp_path / "in/plate.0001.exr").mean(), rel=0.01
    )


def test_scale_keeps_data_type_and_metadata(tmp_path):
    source = oiio.ImageBuf(str(plate(tmp_path / "plate.exr", depth="float")))
    source.specmod().attribute("shot", "sq01")
    source.write(str(tmp_path / "plate.exr"))
    run(tmp_path / "plate.exr", tmp_path / "out.exr", scale=0.5)
    spec = oiio.ImageBuf(str(tmp_path / "out.exr")).spec()
    assert (spec.width, spec.full_height, str(spec.format), spec.get("shot")) == (32, 24, "float", "sq01")


def test_a_file_holds_the_graph_that_made_it(shot, out, tmp_path):
    run(shot, out, set={"stops": 0.5}, frames=1)
    stored = oiio.ImageBuf(out.replace("####", "0001")).spec().get("flowabs:graph")
    again = engine.run(json.loads(stored), frames=1)
    assert statuses(again) == [(1, "skipped")]


def test_profile(shot, out):
    report = run(shot, out, profile=True)
    assert {(time.node, time.type, time.frames) for time in report.profile} >= {
        ("plate", "read", 3),
        ("bright", "exposure", 3),
        ("out", "write", 3),
    }
    assert run(shot, out).profile is None


def test_a_frame_can_be_made_by_another_process(shot, out):
    graph = engine.load_graph(document())
    job, frames = build_job(graph, RunOptions(input=shot, output=out))
    again = pickle.loads(pickle.dumps(job))
    report = pickle.loads(pickle.dumps(render_frame(again, frames[0])))
    assert report.status == "done"
    assert render_frame(job, frames[0]).status == "skipped"


def test_a_job_is_small_however_many_frames_there_are_and_holds_every_rule(shot, out):
    rules = {"existing": "overwrite", "missing": "hold", "scale": 0.5, "max_pixels": 10_000}
    options = RunOptions(input=shot, output=out, frames=range(1, 10_001), set={"stops": 2}, **rules)
    job, frames = build_job(engine.load_graph(document()).with_set(options.set), options)
    assert len(frames) == 10_000
    assert len(pickle.dumps(job)) < 2000
    assert pickle.loads(pickle.dumps(job)).options == RunOptions(**rules)


def test_ten_thousand_frames_hold_no_image(tmp_path, out):
    import gc
    import weakref

    held = []

    def watch(context, image):
        result = image.with_pixels(image.pixels * 2)
        held.append(weakref.ref(result))
        gc.collect()
        assert sum(each() is not None for each in held) <= 1, "the last frame's image is still held"
        if context.frame % 2:
            raise ValueError("a failed frame lets go as well")
        return result

    report = run(plate(tmp_path / "plate.exr"), out, graph_around(watch), frames="1-12")
    assert [frame.error.code if frame.error else "" for frame in report.frames] == ["internal", ""] * 6


def test_what_is_wrong_with_a_graph_but_does_not_keep_it_from_running_is_said(shot, out):
    events = []
    run(
        shot, out, document(idle={"type": "exposure@1", "inputs": {"image": "plate"}}), frames=1, on_event=events.append
    )
    assert any(event["event"] == "note" and event["level"] == "warning" and "idle" in event["text"] for event in events)


def test_a_warning_about_thin_lines_is_said_once(shot, out):
    def passes(context, image, *, width):
        return image

    graph = graph_around(passes, Param.float("width", 1.0, min=0.1, unit="px", thin_below=1, help="Width."))
    events = []
    run(shot, out, graph, scale=0.5, on_event=events.append)
    assert sum("width is 0.5 px" in event.get("text", "") for event in events) == 1
