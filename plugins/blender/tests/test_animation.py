"""Curves of graphs are F-curves, and Blender's keyframes, of any interpolation, are curves of graphs."""

from typing import Any

import bpy
import pytest
from flowabs_blender import fcurves, node_body, tree_json
from flowabs_blender.node_classes import declaration_of
from test_editing import node_of

from graphs import WIDTH, small, with_knobs, with_params


def curve_of(tree: Any, name: str, param: str) -> Any:
    node = node_of(tree, name)
    return fcurves.find(tree, node_body.path(node, declaration_of(node).all_params[param]))


def params(tree: Any, name: str) -> Any:
    return tree_json.graph_of(tree)["nodes"][name].get("params")


def test_a_curve_is_an_fcurve(tree_of: Any) -> None:
    tree = tree_of(with_params("etf@1", radius={"curve": {"1001": 2, "1011": 7}}))
    curve = curve_of(tree, "x", "radius")
    assert [curve.evaluate(frame) for frame in (900, 1001, 1006, 1011, 2000)] == [2, 2, 4.5, 7, 7]


def test_keys_are_moved(tree_of: Any) -> None:
    tree = tree_of(with_params("etf@1", radius={"curve": {"1001": 2, "1011": 7.1}}))
    curve = curve_of(tree, "x", "radius")
    curve.keyframe_points[0].co = (991, 3)
    assert params(tree, "x") == {"radius": {"curve": {"991": 3, "1011": 7.1}}}


def test_keys_of_blender_are_baked(tree_of: Any) -> None:
    """A Bézier segment has a key a frame, a constant one holds until the frame before, a linear one is its ends."""
    tree = tree_of(small())
    node = node_of(tree, "flow")
    for frame, value in ((1, 2), (4, 8), (10, 8), (20, 3), (30, 5)):
        node.p_radius = value
        node.keyframe_insert("p_radius", frame=frame)
    curve = curve_of(tree, "flow", "radius")
    for point, kind in zip(curve.keyframe_points, ("BEZIER", "LINEAR", "CONSTANT", "LINEAR", "LINEAR"), strict=True):
        point.interpolation = kind
    keys = params(tree, "flow")["radius"]["curve"]
    assert list(keys) == ["1", "2", "3", "4", "10", "19", "20", "30"]
    assert [keys[frame] for frame in ("1", "4", "10", "19", "20", "30")] == [2, 8, 8, 8, 3, 5]
    assert keys["2"] == pytest.approx(curve.evaluate(2), rel=1e-6)
    assert 2 < keys["2"] < keys["3"] < 8


def test_keys_between_frames_are_baked(tree_of: Any) -> None:
    tree = tree_of(small())
    node = node_of(tree, "flow")
    for frame, value in ((1.5, 2), (3.5, 6)):
        node.p_radius = value
        node.keyframe_insert("p_radius", frame=frame)
    for point in curve_of(tree, "flow", "radius").keyframe_points:
        point.interpolation = "LINEAR"
    assert params(tree, "flow") == {"radius": {"curve": {"1": 2, "2": 3, "3": 5, "4": 6}}}


def test_modifiers_are_baked_over_the_scene(tree_of: Any) -> None:
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 6
    tree = tree_of(with_params("etf@1", radius={"curve": {"1": 1, "3": 3}}))
    curve_of(tree, "x", "radius").modifiers.new("CYCLES")
    assert list(params(tree, "x")["radius"]["curve"].values()) == [1, 2, 3, 2, 3, 2]


def test_whole_numbers_stay_whole(tree_of: Any) -> None:
    tree = tree_of(small())
    node = node_of(tree, "flow")
    for frame, value in ((1, 1), (5, 3)):
        node.p_iterations = value
        node.keyframe_insert("p_iterations", frame=frame)
    curve_of(tree, "flow", "iterations").keyframe_points[0].interpolation = "BEZIER"
    values = params(tree, "flow")["iterations"]["curve"].values()
    assert all(isinstance(value, int) for value in values)
    assert (min(values), max(values)) == (1, 3)


def test_a_deleted_curve_leaves_the_value(tree_of: Any) -> None:
    tree = tree_of(with_params("etf@1", radius={"curve": {"1": 2, "9": 7}}))
    node = node_of(tree, "x")
    fcurves.remove(tree, curve_of(tree, "x", "radius").data_path)
    node.p_radius = 3
    assert params(tree, "x") == {"radius": 3}


def test_curves_follow_a_renamed_node(tree_of: Any) -> None:
    tree = tree_of(with_params("etf@1", radius={"curve": {"1": 2, "9": 7}}))
    node_of(tree, "x").graph_name = "y"
    assert params(tree, "y") == {"radius": {"curve": {"1": 2, "9": 7}}}


def test_a_knob_takes_keys(tree_of: Any) -> None:
    tree = tree_of(with_knobs(width=WIDTH, drives={"sigma_c": {"from": "width"}}))
    for frame, value in ((1, 1.1), (10, 2.0)):
        tree["width"] = value
        tree.keyframe_insert('["width"]', frame=frame)
    for point in fcurves.find(tree, '["width"]').keyframe_points:
        point.interpolation = "LINEAR"
    assert tree_json.graph_of(tree)["interface"]["width"] == {**WIDTH, "default": {"curve": {"1": 1.1, "10": 2}}}


def test_keys_move_the_sliders_of_a_scene_s_graph(tree_of: Any) -> None:
    tree = tree_of(with_params("etf@1", radius={"curve": {"1": 2, "11": 7}}))
    bpy.context.scene.flowabs_tree = tree
    bpy.context.scene.frame_set(6)
    evaluated = tree.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert node_of(evaluated, "x").p_radius == 4.5
