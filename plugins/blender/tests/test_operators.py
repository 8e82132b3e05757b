"""Import and export say what went wrong in the report area, and lose nothing."""

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from flowabs_blender import import_export, tree_json

from graphs import small


def test_a_graph_of_a_newer_format_is_refused(tmp_path: Path, tree_of: Any) -> None:
    graph = small()
    tree = tree_of(graph)
    file = tmp_path / "new.json"
    file.write_text(json.dumps({**graph, "format": "flowabs.graph/2"}))
    with pytest.raises(RuntimeError, match="newer-version"):
        bpy.ops.flowabs.import_graph(filepath=str(file))
    with pytest.raises(tree_json.GraphError):
        tree_json.fill(tree, {**graph, "format": "flowabs.graph/2"})
    assert len(bpy.data.node_groups) == 1
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(graph)


def test_a_newer_node_is_kept(tmp_path: Path) -> None:
    file = tmp_path / "new.json"
    file.write_text(json.dumps(small(x={"type": "etf@99", "inputs": {"image": "plate"}, "params": {"way": 1}})))
    assert bpy.ops.flowabs.import_graph(filepath=str(file)) == {"FINISHED"}
    assert json.dumps(tree_json.graph_of(bpy.data.node_groups["small"])) == file.read_text()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"{", "bad-json"),
        (b"[]", "wrong-type"),
        (b'{"format": "flowabs.graph/1", "nodes": [1]}', "wrong-type"),
        (b'{"format": "flowabs.graph/1", "nodes": {}, "nodes": {}}', "duplicate-key"),
        (b'{"a": NaN}', "bad-json"),
        (b"\x89PNG\r\n\x1a\n", "bad-json"),
    ],
)
def test_files_that_are_no_graph(content: bytes, said: str, tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    file.write_bytes(content)
    with pytest.raises(RuntimeError, match=said):
        bpy.ops.flowabs.import_graph(filepath=str(file))
    assert not bpy.data.node_groups


def test_files_that_cannot_be_read_or_written(tmp_path: Path, tree_of: Any) -> None:
    tree_of(small())
    with pytest.raises(RuntimeError, match=r"nothing\.json"):
        bpy.ops.flowabs.import_graph(filepath=str(tmp_path / "nothing.json"))
    with pytest.raises(RuntimeError, match="folder"):
        bpy.ops.flowabs.import_graph(filepath=str(tmp_path))
    with pytest.raises(RuntimeError, match="No such file"):
        bpy.ops.flowabs.export_graph(filepath=str(tmp_path / "no" / "a.json"), tree="small")
    with pytest.raises(RuntimeError, match="no flowabs graph 'other'"):
        bpy.ops.flowabs.export_graph(filepath=str(tmp_path / "a.json"), tree="other")
    with pytest.raises(RuntimeError, match="comes with flowabs; there are: abstraction"):
        bpy.ops.flowabs.new_from_preset(preset="abstractoin")


def test_the_first_graph_becomes_the_scene_s() -> None:
    bpy.ops.flowabs.new_from_preset(preset="lines")
    bpy.ops.flowabs.new_from_preset(preset="flat")
    assert bpy.context.scene.flowabs_tree.name == "lines"


def test_an_older_node_is_brought_up_to_date(tree_of: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from flowabs_nodes.nodes import catalogue

    newer = replace(catalogue()["etf"], version=2, upgrades={1: lambda params: {**params, "radius": 7}})
    monkeypatch.setattr(tree_json, "catalogue", lambda: {**catalogue(), "etf": newer})
    document, notes = tree_json.readable(small())
    assert document["nodes"]["flow"]["type"] == "etf@2"
    assert document["nodes"]["flow"]["params"] == {"radius": 7}
    assert notes == ["flow: etf@1 read as etf@2"]


def test_every_preset_has_a_description() -> None:
    for name in import_export.presets():
        properties = type("Properties", (), {"preset": name})()
        assert import_export.FLOWABS_OT_new_from_preset.description(bpy.context, properties)


def test_what_a_graph_says_of_itself(tree_of: Any) -> None:
    graph = {**small(), "ui": {"note": 1}}
    tree = tree_of(graph)
    bpy.context.scene.flowabs_tree = tree
    bpy.ops.flowabs.edit_graph(side="none")
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(graph)
    bpy.ops.flowabs.edit_graph(description_text="Fine lines.", side="shorter", size=540)
    said = tree_json.graph_of(tree)
    assert (said["description"], said["reference_size"]) == ("Fine lines.", {"shorter": 540})
    assert list(said) == ["format", "name", "description", "reference_size", "nodes", "ui"]
    assert not tree.problems
    bpy.ops.flowabs.edit_graph(side="none")
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(graph)


def test_a_path_that_is_no_utf8_is_said(tree_of: Any, tmp_path: Path) -> None:
    tree = tree_of(small())
    file = tmp_path / "a.json"
    file.write_text("before")
    tree.nodes["plate"].p_file = b"/a\xff.exr".decode(errors="surrogateescape")
    assert tree_json.graph_of(tree)["nodes"]["plate"]["params"]["file"] == "/a\udcff.exr"
    with pytest.raises(RuntimeError, match="cannot be written in UTF-8"):
        bpy.ops.flowabs.export_graph(filepath=str(file), tree="small")
    assert file.read_text() == "before"
    assert [each.name for each in tmp_path.iterdir()] == ["a.json"]


@pytest.mark.parametrize("graph", [None, [], 3, {"nodes": {1: {}}, "x": object()}, {"nodes": {"\ud800": {}}}])
def test_what_is_no_graph_fills_nothing(graph: Any, tree_of: Any) -> None:
    tree = tree_of(small())
    with pytest.raises(tree_json.GraphError):
        tree_json.fill(tree, graph)
    assert json.dumps(tree_json.graph_of(tree)) == json.dumps(small())


def test_plain_data_of_python_is_a_graph(tree_of: Any) -> None:
    graph = small(x={"type": "crop@1", "inputs": {"image": "plate"}, "params": {"box": (0, 0, np.int64(4), 5)}})
    assert tree_json.graph_of(tree_of(graph))["nodes"]["x"]["params"] == {"box": [0, 0, 4, 5]}
