"""A graph runs over rendered frames by the engine of ``flowabs run``: the same files, kept where they are whole."""

import threading
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from flowabs_blender import background, sequence_paths
from flowabs_blender.background import Background
from flowabs_blender.background_operator import Attended
from flowabs_blender.sequence_run import SequenceRun
from pictures import picture, write

import flowabs_nodes as fa
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.read import read_image
from flowabs_nodes.simd import compile_hooks
from graphs import small


@pytest.fixture
def shot(tmp_path: Path) -> Path:
    """Return the folder of three frames that a scene has rendered, which is the scene's."""
    for number in (1, 2, 3):
        write(tmp_path / f"shot_{number:04d}.exr", picture(24, 36, 3))
    scene = bpy.context.scene
    scene.render.filepath = str(tmp_path / "shot_")
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.frame_start, scene.frame_end = 1, 3
    return tmp_path


def test_the_scene_s_frames(shot: Path) -> None:
    bpy.ops.flowabs.new_from_preset(preset="lines")
    tree = bpy.data.node_groups["lines"]
    bpy.context.scene.flowabs_tree = tree
    assert bpy.ops.flowabs.run_sequence() == {"FINISHED"}
    fa.run("lines", input=str(shot / "shot_####.exr"), output=str(shot / "by.####.exr"))
    results = [shot / "lines" / f"lines.{number:04d}.exr" for number in (1, 2, 3)]
    for number, result in enumerate(results, 1):
        np.testing.assert_array_equal(read_image(result).pixels, read_image(shot / f"by.{number:04d}.exr").pixels)
    datablock = bpy.data.images["lines.0001.exr"]
    assert (datablock.source, Path(datablock.filepath)) == ("SEQUENCE", results[0])

    times = [result.stat().st_mtime_ns for result in results]
    results[1].unlink()
    bpy.ops.flowabs.run_sequence()  # makes only what is missing
    assert [result.stat().st_mtime_ns == before for result, before in zip(results, times, strict=True)] == [1, 0, 1]


@pytest.mark.parametrize("name", ["toon", "outline"])
def test_a_graph_for_renders_reads_passes_and_the_frames_around(name: str, tmp_path: Path) -> None:
    passes = Path(__file__).parents[3] / "tests" / "data" / "blender" / "passes_45.####.exr"
    bpy.ops.flowabs.new_from_preset(preset=name)
    made, by = tmp_path / "made.####.exr", tmp_path / "by.####.exr"
    bpy.ops.flowabs.run_sequence(tree=name, frames_in=str(passes), frames_out=str(made), frame_range="1-3")
    fa.run(name, input=str(passes), output=str(by))
    for number in ("0001", "0002", "0003"):
        one, other = (read_image(str(file).replace("####", number)).pixels for file in (made, by))
        np.testing.assert_array_equal(one, other)


def test_animated_knobs_and_one_output(shot: Path) -> None:
    bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = bpy.data.node_groups["abstraction"]
    tree["ink_opacity"] = 0.0
    tree.keyframe_insert('["ink_opacity"]', frame=1)
    tree["ink_opacity"] = 1.0
    tree.keyframe_insert('["ink_opacity"]', frame=3)
    tree.run_settings.frame_range = "1-3x2"
    bpy.ops.flowabs.run_sequence(frames_out=str(shot / "a.####.exr"))
    assert not (shot / "a.0002.exr").exists()
    for number, opacity in ((1, 0), (3, 1)):
        plate = read_image(shot / f"shot_{number:04d}.exr")
        expected = fa.load_graph("abstraction").run(
            given={"plate": plate}, set={"ink_opacity": opacity}, outputs="comp"
        )["comp"]
        made = read_image(shot / f"a.{number:04d}.exr").pixels
        np.testing.assert_allclose(made[..., :3], expected.pixels[..., :3], rtol=2e-3, atol=2e-3)
    bpy.ops.flowabs.run_sequence(frames_out=str(shot / "smooth.####.exr"), output="smooth", frame_range="2")
    assert (shot / "smooth.0002.exr").is_file()


def test_frames_that_fail_are_reported_and_the_others_made(shot: Path) -> None:
    (shot / "shot_0002.exr").write_bytes(b"nothing")
    bpy.ops.flowabs.new_from_preset(preset="lines")
    with pytest.raises(RuntimeError, match=r"shot_0002\.exr.*frame 2.*not an EXR file"):
        bpy.ops.flowabs.run_sequence(tree="lines")
    assert (shot / "lines" / "lines.0003.exr").is_file()


def test_a_file_of_somebody_else_s_is_not_replaced(shot: Path) -> None:
    bpy.ops.flowabs.new_from_preset(preset="lines")
    before = (shot / "shot_0001.exr").read_bytes()
    write(shot / "mine.0001.exr", picture(4, 4, 3))
    said = {"tree": "lines", "frame_range": "1"}
    with pytest.raises(RuntimeError, match=r"was not written by flowabs \(choose another folder, or Overwrite\)"):
        bpy.ops.flowabs.run_sequence(frames_out=str(shot / "mine.####.exr"), **said)
    with pytest.raises(RuntimeError, match="would be written over an input"):
        bpy.ops.flowabs.run_sequence(frames_out=str(shot / "shot_####.exr"), **said)
    assert (shot / "shot_0001.exr").read_bytes() == before
    bpy.data.node_groups["lines"].run_settings.existing = "overwrite"
    bpy.ops.flowabs.run_sequence(frames_out=str(shot / "mine.####.exr"), **said)
    assert read_image(shot / "mine.0001.exr").pixels.shape == (24, 36, 3)


def test_no_frames(tmp_path: Path) -> None:
    bpy.ops.flowabs.new_from_preset(preset="lines")
    bpy.context.scene.render.filepath = "//render/"
    with pytest.raises(RuntimeError, match=r"beside a \.blend that is not saved yet \(save the \.blend"):
        bpy.ops.flowabs.run_sequence(tree="lines")
    with pytest.raises(RuntimeError, match=r"nothing\.0001\.exr.*no such file"):
        bpy.ops.flowabs.run_sequence(tree="lines", frames_in=str(tmp_path / "nothing.####.exr"), frame_range="1")


@pytest.mark.parametrize(
    ("said", "pattern"),
    [
        ("a", "a####.exr"),
        ("a_##.exr", "a_##.exr"),
        ("a.######", "a.######.exr"),
        ("shot01_", "shot01_####.exr"),
        ("", "####.exr"),
    ],
)
def test_the_pattern_of_a_scene_s_frames(said: str, pattern: str, tmp_path: Path) -> None:
    scene = bpy.context.scene
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = f"{tmp_path}/{said}"
    assert sequence_paths.rendered(scene) == f"{tmp_path}/{pattern}"
    scene.frame_start, scene.frame_end, scene.frame_step = 3, 9, 2
    assert sequence_paths.scene_range(scene) == "3-9x2"


# ---------------------------------------------------------------------- in the background


def test_esc_ends_a_run_within_a_second(tmp_path: Path) -> None:
    for number in range(1, 31):
        write(tmp_path / f"a.{number:04d}.exr", picture(200, 300, 3))
    work = Background(SequenceRun("abstraction", str(tmp_path / "a.####.exr"), str(tmp_path / "b.####.exr"), "1-30"))
    attended = Attended(work.start(), "Run")
    while work.progress == 0 and work.running:
        assert not attended.on_event("TIMER", "NOTHING")
        time.sleep(0.01)
    assert "%" in attended.status
    assert "frame 1" in attended.status
    assert not attended.on_event("MOUSEMOVE", "NOTHING")
    begin = time.monotonic()
    assert attended.on_event("ESC", "PRESS")  # at once for Blender
    assert work.wait(5)
    assert time.monotonic() - begin < 1
    assert not [path for path in tmp_path.iterdir() if not path.name.startswith(("a.", "b."))]
    made = len(list(tmp_path.glob("b.*.exr")))
    assert made < 30


def test_what_a_background_tells() -> None:
    begun, go_on = threading.Event(), threading.Event()

    def work(own: Background[int]) -> int:
        own.hear({"event": "node", "status": "started", "frame": 3, "node": "lines", "percent": 40.0, "progress": 0.5})
        own.hear({"event": "note", "node": "plate", "level": "warning", "text": "odd"})
        begun.set()
        go_on.wait(10)
        return 7

    one = Background(work).start()
    assert begun.wait(10)
    assert (one.running, one.progress, one.text, one.notes) == (
        True, 0.4, "frame 3: lines", [("warning", "plate: odd")],
    )  # fmt: skip
    assert one in background.at_work()
    go_on.set()
    assert one.wait(10)
    assert one.result() == 7
    assert not background.at_work()


def test_the_status_says_when_filters_are_compiled() -> None:
    go_on = threading.Event()
    work = Background(lambda own: go_on.wait(10)).start()
    compile_hooks.tell()
    assert Attended(work, "Run").status == "Run: 0%, filters are compiled, once on this machine   (Esc cancels)"
    go_on.set()
    work.wait()


def test_what_goes_wrong_comes_out() -> None:
    def work(own: Background[None]) -> None:
        raise CommandError("no")

    one = Background(work).start()
    one.wait()
    with pytest.raises(CommandError, match="no"):
        one.result()

    def fault(own: Background[None]) -> None:
        raise ZeroDivisionError("division by zero")

    two = Background(fault).start()
    two.wait()
    with pytest.raises(fa.FlowabsError, match="ZeroDivisionError: division by zero"):
        two.result()


def test_another_file_ends_all_work(tmp_path: Path) -> None:
    write(tmp_path / "a.exr", picture(400, 600, 3))
    work = Background(SequenceRun("abstraction", str(tmp_path / "a.exr"), str(tmp_path / "b.####.exr"), "1-50")).start()
    bpy.ops.wm.read_homefile(use_empty=True)
    assert work.wait(5)
    assert work.cancelled
    assert len(list(tmp_path.glob("b.*.exr"))) < 50


def test_a_graph_without_write_says_so(shot: Path, tree_of: Any) -> None:
    graph = small()
    del graph["nodes"]["out"]
    bpy.context.scene.flowabs_tree = tree_of(graph)
    with pytest.raises(RuntimeError, match=r"no write node \(choose an output, or add a Write node\)"):
        bpy.ops.flowabs.run_sequence()
    bpy.ops.flowabs.run_sequence(output="lines")
    assert (shot / "small" / "small.0003.exr").is_file()
