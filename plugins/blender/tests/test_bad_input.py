"""What cannot be run is said in the report area: nothing is lost, and nothing waits."""

import json
import os
from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import pytest
from flowabs_blender import import_export, tree_json
from pictures import held, made, picture, rendered, write

from flowabs_nodes.errors import ReadError
from flowabs_nodes.graph import GraphError
from graphs import small


@pytest.fixture
def scene_tree(tree_of: Any) -> Any:
    """Return the function that makes a graph the scene's tree."""

    def make(graph: dict[str, Any]) -> Any:
        bpy.context.scene.flowabs_tree = tree_of(graph)
        return bpy.context.scene.flowabs_tree

    return make


def refused(image: str, said: str, tree: Any) -> None:
    """Run the scene's graph, which must fail with these words and leave all as it was."""
    graph, images = json.dumps(tree_json.graph_of(tree)), {each.name for each in bpy.data.images}
    with pytest.raises(RuntimeError, match=said):
        bpy.ops.flowabs.run(image=image)
    assert json.dumps(tree_json.graph_of(tree)) == graph
    assert {each.name for each in bpy.data.images} == images


def test_a_picture_without_pixels(scene_tree: Any) -> None:
    tree = scene_tree(small())
    empty = bpy.data.images.new("empty", 4, 4)
    empty.source = "FILE"
    refused("empty", r"Error: image 'empty': there are no pixels", tree)
    bpy.data.images.new("tiles", 4, 4, tiled=True)
    refused("tiles", r"image 'tiles' is a picture of several tiles \(UDIM\) \(run the graph on the file of", tree)


def test_no_picture_and_no_graph(scene_tree: Any) -> None:
    tree = scene_tree(small())
    refused("", r"no picture is chosen", tree)
    refused("nothing", r"there is no image 'nothing'", tree)
    with pytest.raises(RuntimeError, match="there is no flowabs graph 'nothing'"):
        bpy.ops.flowabs.run(tree="nothing")
    bpy.context.scene.flowabs_tree = None
    with pytest.raises(RuntimeError, match=r"no flowabs graph is shown here"):
        bpy.ops.flowabs.run()


def test_a_multilayer_image(tmp_path: Path, scene_tree: Any) -> None:
    names = [f"{layer}.Combined.{channel}" for layer in ("Fg", "Bg") for channel in "RGB"]
    bpy.data.images.load(write(tmp_path / "a.exr", picture(channels=6), names=names)).name = "layers"
    tree = scene_tree(small())
    refused("layers", r"a\.exr: .*image 'layers': several layers could be meant: Bg.Combined, Fg.Combined", tree)
    tree.nodes["plate"].p_layer = "Bg"  # which the message asks for
    assert bpy.ops.flowabs.run(image="layers") == {"FINISHED"}


def test_a_packed_or_missing_file(tmp_path: Path, scene_tree: Any) -> None:
    tree = scene_tree(small())
    file = write(tmp_path / "a.exr", picture(channels=3))
    packed = bpy.data.images.load(file)
    packed.name = "packed"
    bpy.data.images.load(file, check_existing=False).name = "missing"
    packed.pack()
    os.remove(file)
    refused("missing", r"a\.exr: image 'missing': no such file", tree)
    assert bpy.ops.flowabs.run(image="packed") == {"FINISHED"}


def test_an_unlinked_input(scene_tree: Any) -> None:
    made(picture(), name="plate")
    refused(
        "plate",
        "the graph cannot run: lines: Flow is not linked",
        scene_tree(small(lines={"type": "fdog@1", "inputs": {"image": "plate"}})),
    )


def test_a_graph_of_a_newer_version(tmp_path: Path, scene_tree: Any) -> None:
    made(picture(), name="plate")
    file = tmp_path / "new.json"
    import_export.write_graph({**small(), "format": "flowabs.graph/2"}, file)
    with pytest.raises(GraphError, match="newer-version"):
        flowabs_blender.run(str(file), "plate")
    refused(
        "plate",
        r"lines: .*newer.*fdog@99",
        scene_tree(small(lines={"type": "fdog@99", "inputs": {"image": "plate", "flow": "flow"}})),
    )


def test_a_node_whose_package_is_missing(scene_tree: Any) -> None:
    made(picture(), name="plate")
    body = {
        "type": "studio_lines@3",
        "inputs": {"image": "plate", "flow": "flow"},
        "params": {"width": [1, {"a": None}]},
    }
    refused("plate", r"lines: not installed: .*studio_lines@3", scene_tree(small(lines=body)))


def test_a_render_without_the_pass(tmp_path: Path, scene_tree: Any) -> None:
    tree = scene_tree(small(depth={"type": "read_depth@1"}))
    rendered()
    with pytest.raises(
        RuntimeError, match=r"node depth: .*no layer with a usual name for depth.*on under View Layer Prop"
    ):
        bpy.ops.flowabs.run_on_render(output="depth")
    made(picture(), name="plate")
    tree.run_settings.output = "depth"
    refused("plate", r"node depth.*\(set the node's file, or run on a picture that is a file with such a pass\)", tree)
    tree.run_settings.output = ""
    assert bpy.ops.flowabs.run_on_render() == {"FINISHED"}  # of what is not asked for nobody cares


def test_a_plate_of_another_size_than_a_mask(tmp_path: Path, scene_tree: Any) -> None:
    mask = write(tmp_path / "mask.exr", picture(3, 4, 3))
    made(picture(5, 7), name="plate")
    graph = small(
        mask={"type": "read@1", "params": {"file": mask}},
        matte={"type": "matte@1", "inputs": {"image": "mask"}},
        out={"type": "write@1", "inputs": {"image": "flat"}},
        flat={"type": "fbl@1", "inputs": {"image": "plate", "flow": "flow", "mask": "matte"}},
    )
    refused("plate", r"node flat: input 'mask' is of a picture of 4x3, but input 'image' of 7x5", scene_tree(graph))


def test_a_damaged_file(tmp_path: Path) -> None:
    file = tmp_path / "a.exr"
    file.write_bytes(b"nothing")
    with pytest.raises(ReadError, match="not an EXR file"):
        flowabs_blender.run("lines", str(file))


def test_a_file_that_cannot_be_written(tmp_path: Path, scene_tree: Any) -> None:
    scene_tree(small())
    plate = made(picture(), name="plate")
    before = held(plate)
    with pytest.raises(RuntimeError, match=r"Error: .*a\.xyz: not a picture format that is written here"):
        bpy.ops.flowabs.run(image="plate", file=str(tmp_path / "a.xyz"))
    np.testing.assert_array_equal(held(plate), before)
    assert not list(tmp_path.iterdir())
