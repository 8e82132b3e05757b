"""Render regions, view layers and eyes, in renders of Cycles: the graph gets the right ones, each in its place."""

from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import shot
from composites import PASSES, composite, expected, set_up, story, with_layers
from outside import outside

from flowabs_nodes.io.read import read_image


def render_regions(folder: str) -> dict[str, Any]:
    """Render frame 2 whole, and a region of it with and without Crop to Render Region."""
    told = {}
    shot.make()
    first = bpy.context.scene
    first.frame_start = first.frame_end = 2
    render = first.render
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.31, 0.77, 0.22, 0.9
    for name, border, crop in (("whole", False, False), ("region", True, False), ("cropped", True, True)):
        render.use_border, render.use_crop_to_border = border, crop
        _, second = set_up(str(Path(folder) / name), graph=PASSES)
        shot.render(first)
        shot.render(second)
        told[name] = story(first, second)
        flowabs_blender.remove_compositing(first)
    return told


def test_a_render_region_lies_where_it_was(tmp_path: Path) -> None:
    told = outside(render_regions, tmp_path)
    rows, columns = slice(3, 22), slice(14, 36)  # in Blender's whole pixels: 48 x .31 to 48 x .77, 27 x .22 to 27 x .9
    whole = read_image(shot.frame_file(told["whole"]["passes"], 2))
    for name in ("region", "cropped"):
        assert told[name]["problems"] == told[name]["passes_problems"] == ""
        image = read_image(shot.frame_file(told[name]["passes"], 2))
        assert image.data_window == (14, 3, 22, 19)
        assert image.display_window == (0, 0, 48, 27)
        np.testing.assert_array_equal(image.pixels, whole.pixels[rows, columns])
        assert image.spec.getattribute("cycles.ViewLayer.samples")
        found = composite(told[name], 2)
        np.testing.assert_array_equal(found, expected(told[name], 2))
        assert (found[:3] == 0).all()
        assert found[rows, columns, 3].min() == 1
    np.testing.assert_array_equal(composite(told["region"], 2), composite(told["cropped"], 2))


def render_layers_and_eyes(folder: str) -> dict[str, Any]:
    """Render two view layers, then two eyes, a frame of each."""
    shot.make()
    first = bpy.context.scene
    first.frame_end = 1
    near = first.view_layers.new("Near.1")
    near.material_override = bpy.data.materials.new("grey")
    _, second = set_up(str(Path(folder) / "layers"), LAYERS)
    shot.render(first)
    shot.render(second)
    told = {"layers": story(first, second)}
    second.flowabs_tree.nodes["plate"].p_layer = ""
    shot.render(second)
    told["unnamed"] = story(first, second)
    flowabs_blender.remove_compositing(second)
    first.view_layers.remove(near)
    first.render.use_multiview = True
    for name, graph in (("left", PASSES), ("right", EYES)):
        _, second = set_up(str(Path(folder) / name), graph)
        shot.render(first)
        shot.render(second)
        told[name] = story(first, second)
        flowabs_blender.remove_compositing(second)
    return told


LAYERS = with_layers(plate="Near.1", albedo="Near.1.albedo", depth="Near.1", ids="Near.1.cryptomatte")
EYES = with_layers(plate="right", albedo="albedo.right", depth="Depth.right", ids="cryptomatte.right")


def test_view_layers_and_eyes(tmp_path: Path) -> None:
    told = outside(render_layers_and_eyes, tmp_path)
    for name, graph in (("layers", LAYERS), ("left", PASSES), ("right", EYES)):
        assert told[name]["problems"] == ""
        file = shot.frame_file(told[name]["passes"], 1)
        assert composite(told[name], 1).shape == (27, 48, 4)
        if name != "layers":  # rendered again without its layer
            np.testing.assert_array_equal(composite(told[name], 1), expected(told[name], 1, graph))
        else:
            near, usual = (read_image(file, layer=layer).pixels for layer in ("Near.1", "ViewLayer"))
            assert not np.array_equal(near, usual)
    assert not np.array_equal(composite(told["left"], 1), composite(told["right"], 1))
    assert "several layers could be meant" in told["unnamed"]["problems"]
    assert "Near.1" in told["unnamed"]["problems"]
