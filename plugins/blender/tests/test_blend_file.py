"""A graph stays in the .blend: without users, and without the package of a node, or the extension itself."""

import json
from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import pytest
from flowabs_blender import node_body, tree_json
from flowabs_blender.identifiers import node_id
from test_editing import node_of

from flowabs_nodes.nodes import catalogue
from graphs import WIDTH, small, with_knobs

GRAPH = with_knobs(width=WIDTH, drives={"sigma_c": {"from": "width"}, "rho": {"curve": {"1": 0.9, "5": 0.1}}})


def save_and_open(folder: Path) -> None:
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(folder / "a.blend"))


def test_a_graph_without_users_is_kept(tree_of: Any, tmp_path: Path) -> None:
    tree_of(GRAPH)
    for _ in range(2):
        save_and_open(tmp_path)
    assert json.dumps(tree_json.graph_of(bpy.data.node_groups["small"])) == json.dumps(GRAPH)


def test_a_fake_user_may_be_taken(tree_of: Any) -> None:
    tree = tree_of(GRAPH)
    assert tree.use_fake_user
    tree.use_fake_user = False
    tree.nodes.new("FlowabsNode_etf")
    assert not tree.use_fake_user


def test_a_node_whose_package_goes_is_kept(tree_of: Any, tmp_path: Path) -> None:
    """As when a .blend is opened where the package is not installed: Blender calls the node undefined."""
    graph = small(
        mild={"type": "quantize@1", "inputs": {"image": "plate"}, "params": {"levels": 5}},
        after={"type": "blur@1", "inputs": {"image": "mild", "mask": "lines"}},
    )
    tree = tree_of(graph)
    node_of(tree, "mild").p_softness = 0.3
    expected = json.dumps(tree_json.graph_of(tree))
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    (quantize,) = (each for each in flowabs_blender._classes if each.__name__ == node_id("quantize"))
    bpy.ops.wm.read_homefile(use_empty=True)  # as in life, classes come and go while no graph is open
    bpy.utils.unregister_class(quantize)
    try:
        for _ in range(2):
            bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
            tree = bpy.data.node_groups["small"]
            assert "NodeUndefined" in {node.bl_idname for node in tree.nodes}
            tree.update()
            assert json.dumps(tree_json.graph_of(tree)) == expected
            bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    finally:
        bpy.ops.wm.read_homefile(use_empty=True)
        bpy.utils.register_class(quantize)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    tree = bpy.data.node_groups["small"]
    assert node_of(tree, "mild").p_levels == 5
    assert json.dumps(tree_json.graph_of(tree)) == expected


def test_a_file_survives_a_save_without_the_extension(tree_of: Any, tmp_path: Path) -> None:
    tree_of(GRAPH)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    flowabs_blender.unregister()
    try:
        save_and_open(tmp_path)
        save_and_open(tmp_path)
    finally:
        flowabs_blender.register()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    assert json.dumps(tree_json.graph_of(bpy.data.node_groups["small"])) == json.dumps(GRAPH)


def test_enabled_and_disabled_while_a_graph_is_open(tree_of: Any, capfd: pytest.CaptureFixture[str]) -> None:
    tree_of(GRAPH)
    flowabs_blender.unregister()
    flowabs_blender.register()
    tree = bpy.data.node_groups["small"]
    node_of(tree, "flow").p_radius = 6
    assert tree_json.graph_of(tree)["nodes"]["flow"]["params"] == {"radius": 6}
    said = "".join(capfd.readouterr())
    assert "Traceback" not in said, said
    assert "Error" not in said, said


def test_registered_twice_leaves_nothing_behind() -> None:
    flowabs_blender.unregister()
    assert not hasattr(bpy.types.Scene, "flowabs_tree")
    with pytest.raises(TypeError, match="FlowabsTree"):
        bpy.data.node_groups.new("none", "FlowabsTree")
    flowabs_blender.register()
    assert bpy.data.node_groups.new("again", "FlowabsTree").bl_idname == "FlowabsTree"


def test_a_node_comes_back_when_its_package_is_installed(tree_of: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = small(
        mild={"type": "quantize@1", "inputs": {"image": "plate"}, "params": {"levels": 5}},
        after={"type": "merge@1", "inputs": {"B": "mild", "A": "mild.image"}},
        end={"type": "write@1", "inputs": {"image": "mild"}},
    )
    graph["ui"] = {"mild": {"pos": [3, 4], "width": 300}}
    rest = {name: node for name, node in catalogue().items() if name != "quantize"}
    with monkeypatch.context() as patch:
        patch.setattr(node_body, "catalogue", lambda: rest)
        tree = tree_of(graph)
    assert node_of(tree, "mild").bl_idname == "FlowabsMissing"
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(graph)
    bpy.context.scene.flowabs_tree = tree
    bpy.ops.flowabs.check()
    assert node_of(tree, "mild").p_levels == 5
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(graph)
