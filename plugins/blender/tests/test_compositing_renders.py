"""What comes out of the compositing flow, in renders of Cycles: each frame's composite is that frame's result."""

import runpy
import sys
from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import pytest
import shot
from composites import PASSES, composite, expected, pixels_of, set_up, story
from outside import outside

import flowabs_nodes as fa
from flowabs_nodes.io.read import read_image

# ---------------------------------------------------------------------- three frames


def render_three(folder: str) -> dict[str, Any]:
    shot.make()
    first, second = set_up(folder)
    shot.render(first)
    shot.render(second)
    assert flowabs_blender.set_up_compositing(second) == second
    second.flowabs_tree.nodes["lines"].p_sigma_m = 5
    told = story(first, second)
    second.render.filepath = str(Path(folder) / "again_####")
    shot.render(second)
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / "shot.blend"))
    return {**told, "again": second.render.filepath}


def render_saved(folder: str) -> dict[str, Any]:
    """Render the last frame of the composite in the .blend that :func:`render_three` saved."""
    bpy.ops.wm.open_mainfile(filepath=str(Path(folder) / "shot.blend"))
    second = bpy.data.scenes["Scene flowabs"]
    second.frame_start = second.frame_end = 3
    second.render.filepath = str(Path(folder) / "saved_####")
    shot.render(second)
    return story(second.flowabs_compositing.source, second)


def test_each_frame_is_that_frame_s_result(tmp_path: Path) -> None:
    told = outside(render_three, tmp_path)
    assert told["problems"] == ""
    found = {frame: composite(told, frame) for frame in shot.FRAMES}
    for frame, pixels in found.items():
        np.testing.assert_array_equal(pixels, expected(told, frame))
        assert pixels.shape == (27, 48, 4)
    assert not np.array_equal(found[1], found[2])
    assert not np.array_equal(found[2], found[3])
    assert np.ptp(found[2]) > 0.2
    again = {**told, "composite": told["again"]}
    lines = {**PASSES["nodes"]["lines"], "params": {"sigma_m": 5}}
    turned = {**PASSES, "nodes": {**PASSES["nodes"], "lines": lines}}
    for frame in shot.FRAMES:
        np.testing.assert_array_equal(composite(again, frame), expected(told, frame, turned))
    saved = outside(render_saved, tmp_path)
    assert saved["problems"] == ""
    np.testing.assert_array_equal(composite(saved, 3), composite(again, 3))


# ---------------------------------------------------------------------- what goes wrong


def render_with_failures(folder: str) -> dict[str, Any]:
    """Render without the file of frame 2, then without a pass, then without the graph."""
    shot.make(size=(320, 180))
    first, second = set_up(folder)
    shot.render(first)
    shot.frame_file(first.render.filepath, 2).unlink()
    shot.render(second)
    told = story(first, second)
    shot.render(first)
    first.view_layers[0].use_pass_z = False
    first.frame_start = first.frame_end = second.frame_start = second.frame_end = 3
    shot.render(first)
    second.render.filepath = str(Path(folder) / "no_depth_####")
    shot.render(second)
    no_depth = story(first, second)
    bpy.data.node_groups.remove(second.flowabs_tree)
    second.render.filepath = str(Path(folder) / "no_graph_####")
    shot.render(second)
    return {"missing": told, "no depth": no_depth, "no graph": story(first, second)}


def test_a_frame_that_fails_shows_no_other_frame_and_says_why(tmp_path: Path) -> None:
    told = outside(render_with_failures, tmp_path)
    missing = told["missing"]
    assert "frame 2" in missing["problems"]
    assert "_passes_0002.exr" in missing["problems"]
    assert len(missing["problems"].splitlines()) == 1
    marked = composite(missing, 2)
    assert is_marked(marked)
    assert marked[:40, :, 1].max() > 0.5  # white letters
    assert not is_marked(composite(missing, 1))
    assert not is_marked(composite(missing, 3))
    assert "depth" in told["no depth"]["problems"]
    assert "no layer" in told["no depth"]["problems"]
    assert "View Layer Properties" in told["no depth"]["problems"]
    assert is_marked(composite(told["no depth"], 3))
    assert "graph is gone" in told["no graph"]["problems"]
    assert is_marked(composite(told["no graph"], 3))


def is_marked(pixels: Any) -> bool:
    """Return whether a picture is stripes, at its left where there are no letters."""
    return set(np.unique(pixels[:, :8, 0])) == {np.float32(0.12), np.float32(0.4)}


# ---------------------------------------------------------------------- how it is rendered


def render_one_frame(folder: str) -> dict[str, Any]:
    """Render frame 2 alone by the operators, in a scene whose compositor has no Render Layers node."""
    first = shot.make()
    if bpy.app.version < (5, 0):
        first.use_nodes = True
        first.node_tree.nodes.clear()
    else:
        first.compositing_node_group = bpy.data.node_groups.new("own", "CompositorNodeTree")
    first, second = set_up(folder)
    first.frame_set(2)
    bpy.ops.flowabs.render_half(passes=True, animation=False)
    second.frame_start = second.frame_end = 2
    bpy.ops.flowabs.render_half(passes=False, animation=True)
    return {**story(first, second), "files": sorted(file.name for file in Path(folder).iterdir())}


def test_one_frame_by_the_operators(tmp_path: Path) -> None:
    told = outside(render_one_frame, tmp_path)
    assert told["files"] == ["Scene_flowabs_0002.exr", "Scene_passes_0002.exr"]
    assert told["problems"] == ""
    np.testing.assert_array_equal(composite(told, 2), expected(told, 2))


def render_lines_and_ink(folder: str) -> dict[str, Any]:
    """Render two outputs, of which the compositor shows the second."""
    shot.make()
    first, second = set_up(folder, outputs=["lines", "comp.ink"])
    first.frame_end = second.frame_end = 1
    tree = flowabs_blender.compositing.compositor.tree_of(second)
    pictures = {node.label: node for node in tree.nodes if node.type == "IMAGE"}
    output = next(node for node in tree.nodes if node.type in ("COMPOSITE", "GROUP_OUTPUT")).inputs[0]
    assert output.links[0].from_node == pictures["lines"]
    tree.links.new(pictures["comp.ink"].outputs[0], output)
    shot.render(first)
    shot.render(second)
    return {**story(first, second), "pictures": sorted(pictures)}


def test_several_outputs_are_pictures_each(tmp_path: Path) -> None:
    told = outside(render_lines_and_ink, tmp_path)
    assert told["pictures"] == ["comp.ink", "lines"]
    loaded = fa.load_graph(PASSES)
    file = str(shot.frame_file(told["passes"], 1))
    loaded = loaded.with_set({f"{name}.file": file for name in ("plate", "albedo", "depth", "ids")})
    ink = loaded.run(1, outputs="comp.ink")["comp.ink"].to_array(channels="RGBA")
    np.testing.assert_array_equal(composite(told, 1), ink)


def run_example(folder: str) -> dict[str, Any]:
    """Run the example script in the shot."""
    scene = shot.make()
    scene.frame_end = 2
    sys.argv = ["blender", "-b", "--python", "composite.py", "--", "flat", folder]
    runpy.run_path(str(Path(__file__).parents[1] / "examples" / "composite.py"), run_name="__main__")
    return story(scene, bpy.data.scenes["Scene flowabs"])


def test_the_example(tmp_path: Path) -> None:
    told = outside(run_example, tmp_path)
    assert told["problems"] == ""
    assert sorted(file.name for file in tmp_path.glob("*.png")) == ["Scene_flowabs_0001.png", "Scene_flowabs_0002.png"]
    one, two = (pixels_of(tmp_path / f"Scene_flowabs_000{frame}.png") for frame in (1, 2))
    assert one.shape == (27, 48, 4)
    assert not np.array_equal(one, two)


def render_in_acescg(folder: str) -> dict[str, Any]:
    """Render in another working space than Rec.709."""
    shot.make()
    bpy.ops.wm.set_working_color_space(working_space="ACEScg")
    first, second = set_up(folder)
    first.frame_end = second.frame_end = 1
    shot.render(first)
    shot.render(second)
    return story(first, second)


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="Blender 4.5 has no working space of the file")
def test_another_working_space(tmp_path: Path) -> None:
    told = outside(render_in_acescg, tmp_path)
    assert told["problems"] == ""
    file = shot.frame_file(told["passes"], 1)
    assert "ap1" in read_image(file).colorspace.name.lower() or "acescg" in read_image(file).colorspace.name.lower()
    np.testing.assert_array_equal(composite(told, 1), expected(told, 1))
