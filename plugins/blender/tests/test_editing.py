"""What an artist changes in the editor is in the exported graph, and nothing else is."""

import copy
import json
from itertools import pairwise
from typing import Any

import bpy
import pytest
from flowabs_blender import import_export, knobs, tree_json
from flowabs_blender.node_classes import declaration_of
from flowabs_blender.sockets import socket_of

import flowabs_nodes
from flowabs_nodes.graph import check
from flowabs_nodes.nodes import catalogue
from graphs import small, with_params

graph_of = tree_json.graph_of


def node_of(tree: Any, name: str) -> Any:
    return next(node for node in tree.nodes if getattr(node, "graph_name", None) == name)


def changed(graph: dict[str, Any], **nodes: Any) -> str:
    """Return the text of a graph in which some nodes have other bodies."""
    return json.dumps({**graph, "nodes": {**graph["nodes"], **nodes}})


def test_a_parameter_that_is_moved(tree_of: Any) -> None:
    graph = with_params("etf@1", radius=0.1, space="lab")
    tree = tree_of(graph)
    node = node_of(tree, "x")
    node.p_pre_blur = 0.3
    node.p_space = "acescct"
    body = {**graph["nodes"]["x"], "params": {"radius": 0.1, "space": "acescct", "pre_blur": 0.3}}
    assert json.dumps(graph_of(tree)) == changed(graph, x=body)


def test_moved_and_moved_back_is_as_before(tree_of: Any) -> None:
    graph = small()
    tree = tree_of(graph)
    node_of(tree, "flow").p_radius = 8
    node_of(tree, "flow").p_radius = 5
    assert json.dumps(graph_of(tree)) == json.dumps(graph)


@pytest.mark.parametrize("value", [0.1, 0.3, 1 / 3, 2.5])
def test_a_float_has_the_fewest_digits(tree_of: Any, value: float) -> None:
    tree = tree_of(small())
    node_of(tree, "flow").p_pre_blur = value
    said = graph_of(tree)["nodes"]["flow"]["params"]["pre_blur"]
    assert said == pytest.approx(value, rel=1e-6)
    assert len(repr(said)) <= 10


def test_null_and_back(tree_of: Any) -> None:
    tree = tree_of(small())
    node = node_of(tree, "lines")
    node.auto_contrast = False
    node.p_contrast = 2
    assert graph_of(tree)["nodes"]["lines"]["params"] == {"contrast": 2}
    node.auto_contrast = True
    assert "params" not in graph_of(tree)["nodes"]["lines"]


def test_custom_values_are_json_or_text(tree_of: Any) -> None:
    tree = tree_of(small())
    node = node_of(tree, "flow")
    for text, value in (("p99.5", "p99.5"), ("16", 16), ('"16"', "16")):
        node.p_gradient_reference = text
        assert graph_of(tree)["nodes"]["flow"]["params"] == {"gradient_reference": value}


def test_hard_ranges_hold(tree_of: Any) -> None:
    tree = tree_of(small(x={"type": "bilateral@1", "inputs": {"image": "plate"}}))
    node = node_of(tree, "x")
    node.p_sigma_r = -1
    assert 0 < node.p_sigma_r < 1e-40
    assert not [problem for problem in check(graph_of(tree)) if not problem.warning]


def test_every_property_of_every_node_exports_what_it_says(tree_of: Any) -> None:
    """Set each to an end of its range, or another choice; the graph says so, and check has nothing against it."""
    for declaration in catalogue().values():
        for param in declaration.all_params.values():
            tree = tree_of({"format": "flowabs.graph/1", "nodes": {"x": {"type": declaration.name}}})
            node = tree.nodes[0]
            match param.kind:
                case "float" | "int":
                    setattr(node, f"p_{param.name}", param.min if param.min is not None else -1)
                    if param.nullable:
                        setattr(node, f"auto_{param.name}", param.default is not None)
                case "bool":
                    setattr(node, f"p_{param.name}", not param.default)
                case "enum":
                    others = [choice for choice in param.choices if choice != param.default]
                    setattr(node, f"p_{param.name}", others[-1])
                case "color":
                    setattr(node, f"p_{param.name}", (0.1, 0.2, 0.3))
                case _:
                    setattr(node, f"p_{param.name}", "a")
            said = graph_of(tree)["nodes"]["x"]
            if param.default == param.min and not param.above and param.numeric and not param.nullable:
                assert "params" not in said
                continue
            assert list(said["params"]) == [param.name], (declaration.type, param.name)
            if param.kind != "custom":
                assert param.problem(said["params"][param.name]) is None, (declaration.type, param.name, said)


def test_renamed(tree_of: Any) -> None:
    graph = json.loads(import_export.presets()["abstraction"].read_text())
    tree = tree_of(graph)
    node_of(tree, "flow").graph_name = "my flow.001"
    expected = json.loads(json.dumps(graph).replace('"flow": "flow"', '"flow": "my_flow"'))
    expected["nodes"] = {("my_flow" if name == "flow" else name): body for name, body in expected["nodes"].items()}
    expected["ui"] = {("my_flow" if name == "flow" else name): look for name, look in expected["ui"].items()}
    assert json.dumps(graph_of(tree)) == json.dumps(expected)


def test_a_name_that_is_taken_is_made_unique(tree_of: Any) -> None:
    tree = tree_of(small())
    node_of(tree, "flow").graph_name = "lines"
    assert set(graph_of(tree)["nodes"]) == {"plate", "lines_2", "lines", "out"}


def test_deleted(tree_of: Any) -> None:
    graph = {**small(), "ui": {"flow": {"pos": [1, 2]}, "note": 1}}
    tree = tree_of(graph)
    tree.nodes.remove(node_of(tree, "flow"))
    said = graph_of(tree)
    assert list(said["nodes"]) == ["plate", "lines", "out"]
    assert said["nodes"]["lines"] == {"type": "fdog@1", "inputs": {"image": "plate"}}
    assert said["ui"] == {"note": 1}


def test_new_nodes_and_links(tree_of: Any) -> None:
    tree = tree_of(small())
    for _ in range(2):
        node = tree.nodes.new("FlowabsNode_quantize")
    tree.links.new(node_of(tree, "plate").outputs[0], socket_of(node.inputs, "image"))
    node.p_levels = 4
    said = graph_of(tree)["nodes"]
    assert said["quantize"] == {"type": "quantize@1"}
    assert said["quantize_2"] == {"type": "quantize@1", "inputs": {"image": "plate"}, "params": {"levels": 4}}


def test_second_outputs_and_reroutes(tree_of: Any) -> None:
    tree = tree_of(small())
    reroutes = [tree.nodes.new("NodeReroute") for _ in range(2)]
    tree.links.new(node_of(tree, "lines").outputs[1], reroutes[0].inputs[0])
    tree.links.new(reroutes[0].outputs[0], reroutes[1].inputs[0])
    tree.links.new(reroutes[1].outputs[0], node_of(tree, "out").inputs[0])
    assert graph_of(tree)["nodes"]["out"] == {"type": "write@1", "inputs": {"image": "lines.response"}}


def test_copies(tree_of: Any) -> None:
    """A copied tree is the same graph; Blender's copy of a node, with what the file said, has a name of its own."""
    graph = with_params("etf@1", radius=0.1)
    tree = tree_of(graph)
    assert json.dumps(graph_of(tree.copy())["nodes"]) == json.dumps(graph["nodes"])


def test_moved_in_the_editor(tree_of: Any) -> None:
    graph = {**small(), "ui": {"flow": {"pos": [220, 160]}, "lines": {"pos": [440, 0], "note": "x"}}}
    tree = tree_of(graph)
    node = node_of(tree, "lines")
    node.location = (node.location[0] + 135, node.location[1] - 240)
    node.hide = True
    assert graph_of(tree)["ui"] == {
        "flow": {"pos": [220, 160]},
        "lines": {"pos": [540, 100], "note": "x", "collapsed": True},
    }


def test_a_frame_of_the_editor_moves_nothing(tree_of: Any) -> None:
    graph = {**small(), "ui": {"flow": {"pos": [220, 160]}}}
    tree = tree_of(graph)
    node_of(tree, "flow").parent = tree.nodes.new("NodeFrame")
    assert json.dumps(graph_of(tree)) == json.dumps(graph)


def test_layers_of_write(tree_of: Any) -> None:
    tree = tree_of(small())
    bpy.context.scene.flowabs_tree = tree
    for _ in range(2):
        bpy.ops.flowabs.add_layer(node="out", layer="ink")
    out = node_of(tree, "out")
    tree.links.new(node_of(tree, "flow").outputs[0], socket_of(out.inputs, "ink_2"))
    bpy.ops.flowabs.remove_layer(node="out", layer="ink")
    assert graph_of(tree)["nodes"]["out"]["inputs"] == {"image": "lines", "ink_2": "flow"}
    socket_of(out.inputs, "ink_2").port = "direction"
    assert graph_of(tree)["nodes"]["out"]["inputs"] == {"image": "lines", "direction": "flow"}


def test_a_tree_made_from_nothing_runs(tree_of: Any) -> None:
    tree = bpy.data.node_groups.new("mine", "FlowabsTree")
    made = [tree.nodes.new(f"FlowabsNode_{name}") for name in ("read", "quantize", "write")]
    for before, after in pairwise(made):
        tree.links.new(before.outputs[0], after.inputs[0])
    graph = flowabs_nodes.load_graph(graph_of(tree))
    assert graph.name == "mine"
    assert list(graph.nodes) == ["read", "quantize", "write"]
    assert tree.use_fake_user


def test_filling_again_replaces_all(tree_of: Any) -> None:
    tree = tree_of(json.loads(import_export.presets()["abstraction"].read_text()))
    graph = copy.deepcopy(small())
    tree_json.fill(tree, graph)
    assert json.dumps(graph_of(tree)) == json.dumps(graph)
    assert not tree.knobs
    assert "line_width" not in tree


def test_an_unknown_rest_can_be_dropped(tree_of: Any) -> None:
    graph = small(x={"type": "blur@1", "inputs": {"image": "nobody"}, "params": {"sparkle": 1, "sigma": 2}})
    tree = tree_of(graph)
    bpy.context.scene.flowabs_tree = tree
    for node in tree.nodes:
        node.select = True
    bpy.ops.flowabs.forget_unknown()
    assert graph_of(tree)["nodes"]["x"] == {"type": "blur@1", "params": {"sigma": 2}}


def test_declarations_are_found(tree_of: Any) -> None:
    tree = tree_of(small(x={"type": "halftone@1"}))
    assert declaration_of(node_of(tree, "flow")).type == "etf"
    assert declaration_of(node_of(tree, "x")) is None
    assert not knobs.is_ours(None)


def test_a_switch_shows_one_free_input(tree_of: Any) -> None:
    tree = tree_of(small(s={"type": "switch@1", "inputs": {"a": "plate", "c": "lines"}}, t={"type": "switch@1"}))
    shown = {name: [socket.port for socket in node_of(tree, name).inputs if not socket.hide] for name in "st"}
    assert shown == {"s": ["a", "b", "c", "d"], "t": ["a", "b"]}
