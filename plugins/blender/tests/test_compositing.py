"""Setting up for the compositor, and taking it away: what is made, what is remembered, what is refused."""

import json
import subprocess
from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import pytest
from flowabs_blender import import_export
from flowabs_blender.compositing import compositor, handlers, settings
from outside import run

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph import GraphError
from graphs import small


def tree(graph: dict[str, Any] | None = None) -> Any:
    return import_export.new_tree(graph or small(), "graph")[0]


def output_of(scene: Any) -> list[Any]:
    """Return what decides where a scene renders to, and which passes."""
    format = scene.render.image_settings
    names = ("file_format", "color_mode", "color_depth", "exr_codec", "views_format")
    switches = pass_switches(scene.view_layers[0])
    return [
        scene.render.filepath,
        *(getattr(format, name) for name in names),
        *(getattr(layer, name) for layer in scene.view_layers for name in switches),
    ]


def pass_switches(view_layer: Any) -> list[str]:
    return [each.identifier for each in view_layer.bl_rna.properties if each.identifier.startswith("use_pass_")]


def counts() -> tuple[int, ...]:
    """Return how many scenes, pictures (but Blender's own) and node trees there are."""
    pictures = [image for image in bpy.data.images if image.type == "IMAGE"]
    return tuple(map(len, (bpy.data.scenes, pictures, bpy.data.node_groups)))


def test_what_is_set_up(tmp_path: Path) -> None:
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.frame_step = 10, 20, 2
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 301, 201, 50
    scene.render.fps, scene.view_settings.exposure = 25, 0.5
    scene.render.image_settings.file_format = "TIFF"
    second = flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path))
    assert scene.render.filepath == str(tmp_path / "Scene_passes_####.exr")
    assert scene.render.image_settings.file_format == "OPEN_EXR_MULTILAYER"
    assert scene.render.image_settings.color_depth == "32"
    assert second.name == "Scene flowabs"
    assert second.render.filepath == str(tmp_path / "Scene_flowabs_####")
    assert second.render.image_settings.file_format == "TIFF"
    assert (second.frame_start, second.frame_end, second.frame_step) == (10, 20, 2)
    assert settings.size_of(second) == (150, 100)
    assert (second.render.fps, second.view_settings.exposure) == (25, 0.5)
    assert second.render.use_lock_interface
    assert not second.collection.all_objects
    assert scene.flowabs_tree == second.flowabs_tree == bpy.data.node_groups["small"]
    (result,) = second.flowabs_compositing.results
    assert (result.name, tuple(result.image.size)) == ("lines", (150, 100))
    assert result.image.is_float


def test_a_second_call_makes_nothing_more(tmp_path: Path) -> None:
    scene = bpy.context.scene
    second = flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path))
    before = counts()
    blur = compositor.tree_of(second).nodes.new("CompositorNodeBlur")
    second.render.filepath = "/elsewhere/"
    scene.frame_end, scene.render.resolution_x = 99, 640
    for of in (scene, second):
        assert flowabs_blender.set_up_compositing(of) == second
    assert counts() == before
    assert blur.name in compositor.tree_of(second).nodes
    assert len(compositor.tree_of(second).nodes) == 3
    assert second.render.filepath == "/elsewhere/"
    assert scene.render.filepath == str(tmp_path / "Scene_passes_####.exr")
    assert (second.frame_end, second.render.resolution_x) == (99, 640)


def test_another_graph_changes_the_pictures(tmp_path: Path) -> None:
    scene = bpy.context.scene
    flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path))
    graph = small(more={"type": "write@1", "inputs": {"image": "plate"}})
    second = flowabs_blender.set_up_compositing(scene, tree(graph), folder=str(tmp_path))
    assert [each.name for each in second.flowabs_compositing.results] == ["lines", "plate"]
    assert len(bpy.data.scenes) == 2
    assert scene.flowabs_tree.name == "small"
    assert second.flowabs_tree.name == "small.001"
    reads = {node.label: node.image for node in compositor.tree_of(second).nodes if node.type == "IMAGE"}
    assert {name: image.name for name, image in reads.items()} == {
        "lines": "lines of Scene flowabs",
        "plate": "plate of Scene flowabs",
    }
    flowabs_blender.set_up_compositing(scene, second.flowabs_tree, outputs="plate")
    reads = {node.label: node.image for node in compositor.tree_of(second).nodes if node.type == "IMAGE"}
    assert reads["lines"] is None
    assert reads["plate"] is not None


def test_undo_takes_it_back_and_it_can_be_set_up_again(tmp_path: Path) -> None:
    bpy.context.scene.flowabs_tree = tree()
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.flowabs.set_up_compositing(folder=str(tmp_path))
    there = counts()
    bpy.ops.ed.undo_push(message="after")
    bpy.ops.ed.undo()
    assert len(bpy.data.scenes) == 1
    assert not bpy.data.scenes[0].flowabs_compositing.before
    bpy.ops.flowabs.set_up_compositing(folder=str(tmp_path))
    assert counts() == there
    bpy.ops.ed.undo_push(message="again")
    bpy.ops.ed.undo()
    bpy.ops.ed.redo()
    assert counts() == there


@pytest.mark.parametrize("from_second", [False, True])
def test_it_is_taken_away(from_second: bool, tmp_path: Path) -> None:
    scene = bpy.context.scene
    scene.render.filepath = "/shots/beauty_"
    scene.render.image_settings.file_format = "JPEG"
    made = tree(small(z={"type": "read_depth@1"}, far={"type": "matte@1", "inputs": {"image": "z"}}))
    before, there = output_of(scene), counts()
    second = flowabs_blender.set_up_compositing(scene, made, folder=str(tmp_path))
    assert scene.view_layers[0].use_pass_z
    assert output_of(scene) != before
    flowabs_blender.set_up_compositing(scene)
    flowabs_blender.remove_compositing(second if from_second else scene)
    assert output_of(scene) == before
    assert counts() == there
    with pytest.raises(FlowabsError, match="'Scene' is not set up for compositing"):
        flowabs_blender.remove_compositing(scene)


def test_an_output_that_was_changed_since_stays(tmp_path: Path) -> None:
    scene = bpy.context.scene
    flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path))
    scene.render.filepath = "/mine/####"
    flowabs_blender.remove_compositing(scene)
    assert scene.render.filepath == "/mine/####"


def test_it_goes_without_the_scene_of_the_shot(tmp_path: Path) -> None:
    scene = bpy.context.scene
    second = flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path))
    bpy.context.window.scene = second
    bpy.data.scenes.remove(scene)
    with pytest.raises(FlowabsError, match="is the only one left"):
        flowabs_blender.remove_compositing(second)
    bpy.data.scenes.new("other")
    flowabs_blender.remove_compositing(second)
    assert [each.name for each in bpy.data.scenes] == ["other"]


@pytest.mark.parametrize(
    ("type", "layer", "switch"),
    [
        ("read_depth", "", "use_pass_z"),
        ("read_depth", "ViewLayer", "use_pass_z"),
        ("read_depth", "Mist", "use_pass_mist"),
        ("read_normal", "", "use_pass_normal"),
        ("read_motion", "right", "use_pass_vector"),
        ("read_id", "", "use_pass_cryptomatte_object"),
        ("read_id", "Fg.cryptomatte.right", "use_pass_cryptomatte_object"),
        ("read_id", "CryptoMaterial", "use_pass_cryptomatte_material"),
        ("read_id", "material", "use_pass_cryptomatte_material"),
        ("read_id", "CryptoAsset00", "use_pass_cryptomatte_asset"),
        ("read_id", "IndexOB", "use_pass_object_index"),
        ("read_id", "Material Index", "use_pass_material_index"),
        ("read", "albedo", "use_pass_diffuse_color"),
        ("read", "Fg.DiffCol", "use_pass_diffuse_color"),
        ("read", "Ambient Occlusion", "use_pass_ambient_occlusion"),
        ("read_aov", "Position", "use_pass_position"),
        ("read", "", None),
        ("read", "my AOV", None),
    ],
)
def test_the_passes_that_a_graph_reads_are_on(type: str, layer: str, switch: str | None, tmp_path: Path) -> None:
    view_layer = bpy.context.scene.view_layers[0]
    names = pass_switches(view_layer)
    before = {name for name in names if getattr(view_layer, name)}
    graph = small(more={"type": f"{type}@1", "params": {"layer": layer}})
    flowabs_blender.set_up_compositing(bpy.context.scene, tree(graph), folder=str(tmp_path))
    found = {name for name in names if getattr(view_layer, name)} - before
    assert found == ({switch} if switch else set())


def test_what_is_refused(tmp_path: Path) -> None:
    scene = bpy.context.scene
    before = output_of(scene)
    with pytest.raises(FlowabsError, match="'Scene' has no flowabs graph"):
        flowabs_blender.set_up_compositing(scene, folder=str(tmp_path))
    with pytest.raises(FlowabsError, match=r"beside the \.blend, which is not saved yet"):
        flowabs_blender.set_up_compositing(scene, tree())
    with pytest.raises(GraphError):
        flowabs_blender.set_up_compositing(
            scene, tree(small(flow={"type": "etf@1", "inputs": {}})), folder=str(tmp_path)
        )
    with pytest.raises(FlowabsError, match="no read node"):
        flowabs_blender.set_up_compositing(
            scene, tree(small(plate={"type": "constant@1", "params": {}})), folder=str(tmp_path)
        )
    with pytest.raises(FlowabsError, match="line"):
        flowabs_blender.set_up_compositing(scene, tree(), folder=str(tmp_path), outputs=["linse"])
    scene.flowabs_tree = tree()
    with pytest.raises(RuntimeError, match=r"beside the \.blend, which is not saved yet"):
        bpy.ops.flowabs.set_up_compositing()
    assert [each.name for each in bpy.data.scenes] == ["Scene"]
    assert output_of(scene) == before


def test_the_operators(tmp_path: Path) -> None:
    scene = bpy.context.scene
    assert not bpy.ops.flowabs.set_up_compositing.poll()
    assert not bpy.ops.flowabs.remove_compositing.poll()
    scene.flowabs_tree = tree()
    assert bpy.ops.flowabs.set_up_compositing(folder=str(tmp_path)) == {"FINISHED"}
    assert bpy.ops.flowabs.set_up_compositing() == {"FINISHED"}
    assert len(bpy.data.scenes) == 2
    assert bpy.ops.flowabs.other_scene() == {"FINISHED"}
    assert bpy.context.window.scene.name == "Scene flowabs"
    assert bpy.ops.flowabs.remove_compositing() == {"FINISHED"}
    assert bpy.context.window.scene == scene
    assert len(bpy.data.scenes) == 1


def test_the_handlers_come_and_go() -> None:
    def there() -> list[str]:
        found = [handler for name in handlers.HANDLERS for handler in getattr(bpy.app.handlers, name)]
        return [handler.__name__ for handler in found if handler.__module__.startswith("flowabs_blender")]

    assert there() == ["forget_problems", "fill_pictures", "finish_passes"]
    flowabs_blender.unregister()
    try:
        assert there() == []
        assert not hasattr(bpy.types.Scene, "flowabs_compositing")
    finally:
        flowabs_blender.register()
    bpy.ops.wm.read_homefile(use_empty=True)
    assert there() == ["forget_problems", "fill_pictures", "finish_passes"]


def leave_everything(folder: str) -> list[str]:
    """Set up, and end without taking anything away."""
    scene = bpy.context.scene
    made = tree()
    second = flowabs_blender.set_up_compositing(scene, made, folder=folder)
    globals()["kept"] = (scene, made, second, second.flowabs_compositing.results[0])
    return [each.name for each in bpy.data.scenes]


def leave_the_trees(folder: str) -> list[str]:
    """As :func:`leave_everything`, but that the extension is unregistered."""
    left = leave_everything(folder)
    flowabs_blender.unregister()
    return left


@pytest.mark.parametrize("leave", [leave_everything, leave_the_trees])
def test_python_ends_with_all_of_it_still_there(leave: Any, tmp_path: Path) -> None:
    try:
        done = run(leave, tmp_path)
    except subprocess.TimeoutExpired as error:
        pytest.fail(f"no end: {error}")
    assert done.returncode == 0
    assert json.loads(done.stdout.rsplit("RESULT ", 1)[1].splitlines()[0]) == ["Scene", "Scene flowabs"]
