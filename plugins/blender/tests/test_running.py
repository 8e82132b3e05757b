"""A graph runs on a picture: the same pixels through Blender, the command line and Python."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import pytest
from flowabs_blender import import_export
from flowabs_blender.read_datablock import image_of
from pictures import held, made, picture, rendered, write

import flowabs_nodes as fa
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.read import read_data, read_image
from graphs import small

HEIGHT, WIDTH = 30, 44


@pytest.fixture
def tree() -> Any:
    """Return the shipped graph "abstraction" as the scene's tree."""
    bpy.ops.flowabs.new_from_preset(preset="abstraction")
    return bpy.data.node_groups["abstraction"]


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    """Return an opaque plate on disk."""
    return Path(write(tmp_path / "plate.exr", picture(HEIGHT, WIDTH, 3)))


def opaque(pixels: Any) -> Any:
    """Return R, G, B with an A of 1."""
    return np.concatenate([pixels[..., :3], np.ones_like(pixels[..., :1])], axis=2)


def by_command(plate: Path, result: Path, *more: str) -> None:
    """Run the graph as an artist does in a shell."""
    command = [sys.executable, "-m", "flowabs_nodes", "run", "abstraction", "-i", str(plate), "-o", str(result), *more]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr


def test_the_same_pixels_by_blender_command_and_python(plate: Path, tree: Any, tmp_path: Path) -> None:
    expected = fa.load_graph("abstraction").run(given={"plate": read_image(plate)}, outputs=["comp"])["comp"].pixels
    by_command(plate, tmp_path / "command.exr", "--set", "out.data_type=float")
    np.testing.assert_array_equal(read_image(tmp_path / "command.exr").pixels, expected)

    loaded = bpy.data.images.load(str(plate))
    np.testing.assert_array_equal(held(flowabs_blender.run(tree, loaded)), opaque(expected))
    np.testing.assert_array_equal(held(flowabs_blender.run("abstraction", str(plate))), opaque(expected))
    packed = bpy.data.images.load(str(plate), check_existing=False)
    packed.pack()
    np.testing.assert_array_equal(held(flowabs_blender.run("abstraction", packed)), opaque(expected))
    painted = made(opaque(read_image(plate).pixels), name="painted")
    np.testing.assert_array_equal(held(flowabs_blender.run(tree.name, "painted")), opaque(expected))

    bpy.ops.flowabs.run(image="painted")
    result = bpy.data.images["abstraction comp"]
    np.testing.assert_array_equal(held(result), opaque(expected))
    assert painted.name in bpy.data.images


@pytest.mark.parametrize("kind", ["png", "tif"])
def test_pictures_of_8_bits_too(kind: str, tmp_path: Path) -> None:
    codes = (picture(HEIGHT, WIDTH, 3) * 120).clip(0, 255).astype(np.uint8)
    file = Path(write(tmp_path / f"a.{kind}", codes, "uint8"))
    expected = fa.load_graph("lines").run(given={"plate": read_image(file)}, outputs="lines")["lines"]
    result = flowabs_blender.run("lines", bpy.data.images.load(str(file)), outputs="lines")
    np.testing.assert_array_equal(held(result)[..., :1], expected.pixels)


def test_an_exr_is_written_as_the_graph_writes_it(plate: Path, tree: Any, tmp_path: Path) -> None:
    by_command(plate, tmp_path / "command.exr")
    bpy.data.images.load(str(plate)).name = "plate"
    bpy.ops.flowabs.run(image="plate", file=str(tmp_path / "blender.exr"))
    ours, theirs = (read_data(tmp_path / f"{name}.exr") for name in ("blender", "command"))
    assert ours.channels == theirs.channels
    assert any(name.startswith("ink.") for name in ours.channels)
    np.testing.assert_array_equal(ours.pixels, theirs.pixels)
    bpy.ops.flowabs.run_to_file(image="plate", output="lines", filepath=str(tmp_path / "lines.exr"))
    lines = read_image(tmp_path / "lines.exr").pixels[..., 0]
    np.testing.assert_allclose(lines, held(bpy.data.images["abstraction lines"])[..., 0], atol=1e-3)


def test_every_output_can_be_chosen(plate: Path, tree: Any) -> None:
    made = flowabs_blender.run(tree, str(plate), outputs=["lines.response", "flow", "smooth"])
    assert {name: image.name for name, image in made.items()} == {
        "lines.response": "abstraction lines.response",
        "flow": "abstraction flow",
        "smooth": "abstraction smooth",
    }
    expected = fa.load_graph("abstraction").run(given={"plate": read_image(plate)}, outputs="flow")["flow"]
    np.testing.assert_array_equal(held(made["flow"])[..., :2], expected.pixels)
    tree.run_settings.image = bpy.data.images.load(str(plate))
    tree.run_settings.output = "lines"
    bpy.ops.flowabs.run()
    assert "abstraction lines" in bpy.data.images


def test_knobs_parameters_frame_and_scale(plate: Path, tree: Any) -> None:
    tree["line_width"] = 2.0
    bpy.context.scene.flowabs_tree = tree
    tree.keyframe_insert('["ink_opacity"]', frame=1)
    tree["ink_opacity"] = 0.25
    tree.keyframe_insert('["ink_opacity"]', frame=5)
    result = flowabs_blender.run(tree, str(plate), set={"lines.softness": 2}, frame=5, scale=0.5, name="mine")
    expected = fa.load_graph("abstraction").run(
        given={"plate": read_image(plate)},
        set={"lines.softness": 2, "line_width": 2, "ink_opacity": 0.25},
        outputs="comp",
        scale=0.5,
    )["comp"]
    assert (result.name, tuple(result.size)) == ("mine", (WIDTH // 2, HEIGHT // 2))
    np.testing.assert_array_equal(held(result), opaque(expected.pixels))


def test_a_result_is_run_again_from_its_plate(plate: Path, tree: Any) -> None:
    bpy.data.images.load(str(plate)).name = "plate"
    bpy.ops.flowabs.run(image="plate")
    first = held(bpy.data.images["abstraction comp"])
    bpy.ops.flowabs.run(image="abstraction comp")
    np.testing.assert_array_equal(held(bpy.data.images["abstraction comp"]), first)


def test_a_multilayer_plate_lends_its_passes(tmp_path: Path, tree_of: Any) -> None:
    light, depth = picture(8, 9, 3), picture(8, 9, 1)
    names = [*(f"ViewLayer.Combined.{channel}" for channel in "RGB"), "ViewLayer.Depth.Z"]
    file = write(tmp_path / "a.exr", np.concatenate([light, depth], axis=2), names=names)
    tree = tree_of(small(depth={"type": "read_depth@1"}))
    for picture_of in (file, bpy.data.images.load(file)):
        shown = flowabs_blender.run(tree, picture_of, outputs=["plate", "depth"])
        np.testing.assert_array_equal(held(shown["plate"]), opaque(light))
        np.testing.assert_array_equal(held(shown["depth"])[..., :1], depth)


def test_the_last_render(tree_of: Any) -> None:
    bpy.context.scene.flowabs_tree = tree_of(small(depth={"type": "read_depth@1"}))
    with pytest.raises(RuntimeError, match="nothing was rendered yet"):
        bpy.ops.flowabs.run_on_render()
    rendered("z")
    before = bpy.context.scene.render.image_settings.file_format
    bpy.ops.flowabs.run_on_render(output="depth")
    depth = held(bpy.data.images["small depth"])
    assert depth.shape == (8, 8, 4)
    assert (depth[..., 0] == np.float32(1e10)).all()  # nothing but background
    assert bpy.context.scene.render.image_settings.file_format == before
    again = flowabs_blender.run("small", "Render Result", outputs="depth")
    np.testing.assert_array_equal(held(again), depth)


def test_names_that_are_wrong(plate: Path) -> None:
    with pytest.raises(CommandError, match=r"no graph named 'abstractoin'.*did you mean 'abstraction'"):
        flowabs_blender.run("abstractoin", str(plate))
    bpy.data.images.new("plate", 4, 4)
    with pytest.raises(CommandError, match=r"'plat' is neither an image .*did you mean 'plate'"):
        flowabs_blender.run("lines", "plat")
    with pytest.raises(CommandError, match="has no output"):
        flowabs_blender.run("lines", str(plate), outputs="lines.nothing")
    other = bpy.data.node_groups.new("shader", "ShaderNodeTree")
    with pytest.raises(CommandError, match="'shader' is no flowabs graph"):
        flowabs_blender.run(other, str(plate))


def test_a_graph_may_be_a_file_or_a_dict(plate: Path, tmp_path: Path) -> None:
    graph = {**small(), "name": "mine"}
    file = tmp_path / "saved.json"
    import_export.write_graph(graph, file)
    assert flowabs_blender.run(str(file), str(plate)).name == "saved lines"
    assert flowabs_blender.run(graph, str(plate)).name == "mine lines"
    np.testing.assert_array_equal(
        image_of(bpy.data.images["saved lines"]).pixels, image_of(bpy.data.images["mine lines"]).pixels
    )
