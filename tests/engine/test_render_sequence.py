"""Whole runs, from EXR files to EXR files: all frames, what is told, how a run ends."""

import gc
import json
import os
import signal
import weakref

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.engine import render_frame as frame_module
from flowabs_nodes.errors import CommandError, WriteError
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Param
from flowabs_nodes.signals import stop_on_signals
from flowabs_nodes.stopping import Stopped
from tests.engine.sequences import (
    document,
    graph_around,
    leftovers,
    pixels,
    plate,
    raising,
    run,
    statuses,
)


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


def test_each_further_output_has_the_same_image_in_its_own_format(shot, out, tmp_path):
    report = run(shot, [out, tmp_path / "look.####.png"], frames=1)
    assert report.frames[0].files == (out.replace("####", "0001"), str(tmp_path / "look.0001.png"))
    assert oiio.ImageBuf(str(tmp_path / "look.0001.png")).file_format_name == "png"
    (tmp_path / "look.0001.png").unlink()
    assert statuses(run(shot, [out, tmp_path / "look.####.png"], frames=1)) == [(1, "done")]
    assert (tmp_path / "look.0001.png").exists()


def test_files_may_be_set_by_name(shot, out):
    assert run(None, None, set={"plate.file": shot, "out.file": out}, frames=1).exit_code == 0


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


def test_a_frame_that_is_done_holds_no_image(tmp_path, out, quick_collection):
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


# ---------------------------------------------------------------------- what is told


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


def test_profile(shot, out):
    report = run(shot, out, profile=True)
    assert {(time.node, time.type, time.frames) for time in report.profile} >= {
        ("plate", "read", 3),
        ("bright", "exposure", 3),
        ("out", "write", 3),
    }
    assert run(shot, out).profile is None


def test_what_is_wrong_with_a_graph_but_does_not_keep_it_from_running_is_said(shot, out):
    events = []
    run(
        shot, out, document(idle={"type": "exposure@1", "inputs": {"image": "plate"}}), frames=1, on_event=events.append
    )
    assert any(event["event"] == "note" and event["level"] == "warning" and "idle" in event["text"] for event in events)


def test_a_note_about_thin_lines_is_said_once(shot, out):
    def passes(context, image, *, width):
        return image

    graph = graph_around(passes, Param.float("width", 1.0, min=0.1, unit="px", thin_below=1, help="Width."))
    events = []
    run(shot, out, graph, scale=0.5, on_event=events.append)
    said = [(each["event"], each.get("frames")) for each in events if "width is 0.5 px" in each.get("text", "")]
    assert said == [("note", None), ("shared-note", "1-3")]


# ---------------------------------------------------------------------- how a run ends before its last frame


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
    report = run(shot, out, raising(Stopped()), on_event=events.append)
    assert statuses(report) == [(1, "done")]
    assert report.exit_code == 130
    assert events[-1]["exit_code"] == 130
    assert not leftovers(tmp_path)


@pytest.mark.parametrize(
    "error", [SystemExit(0), SystemExit("done"), GeneratorExit(), KeyboardInterrupt(), BaseException("no")]
)
def test_a_node_that_wants_to_end_the_process_costs_its_frame_alone(shot, out, tmp_path, error):
    report = run(shot, out, raising(error))
    assert statuses(report) == [(1, "done"), (2, "failed"), (3, "done")]
    assert report.exit_code == 1
    assert "node bright: it tried to end the whole process" in str(report.frames[1].error)
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


@pytest.mark.parametrize(
    ("outputs", "said"),
    [
        (["o.####.exr"], []),
        (["o.####.png"], ["layer ink"]),
        (["o.####.png", "o.####.exr"], []),
        (["o.####.tif"], ["layer ink"]),
    ],
)
def test_layers_that_no_output_holds_are_told_once(shot, tmp_path, outputs, said):
    layered = document(out={"type": "write@1", "inputs": {"image": "bright", "ink": "plate"}})
    events = []
    report = run(shot, [str(tmp_path / "out" / name) for name in outputs], layered, on_event=events.append)
    assert report.exit_code == 0
    told = [event["text"] for event in events if event["event"] == "note" and "left out: layer" in event["text"]]
    assert [text.split(", which")[0].removeprefix("left out: ") for text in told] == said


def test_a_single_picture_is_the_frame_that_its_name_says(tmp_path):
    plate(tmp_path / "move.0004.exr")
    report = run(tmp_path / "move.0004.exr", str(tmp_path / "out.####.exr"))
    assert statuses(report) == [(4, "done")]
    assert (tmp_path / "out.0004.exr").exists()
    plate(tmp_path / "move.exr")
    assert statuses(run(tmp_path / "move.exr", str(tmp_path / "other.####.exr"))) == [(1, "done")]
