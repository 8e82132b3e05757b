"""Knobs are sliders with the graph's range, drive parameters, and are in the exported graph where they stand."""

import json
from typing import Any

import bpy
import pytest
from flowabs_blender import driving, import_export, knob_watch, knobs, node_drawing, tree_json
from flowabs_blender.node_classes import declaration_of
from test_editing import node_of

from graphs import WIDTH, small, with_knobs

graph_of = tree_json.graph_of


def preset(name: str) -> dict[str, Any]:
    return json.loads(import_export.presets()[name].read_text(encoding="utf-8"))


def test_a_slider_has_range_and_help(tree_of: Any) -> None:
    tree = tree_of(preset("abstraction"))
    said = tree.id_properties_ui("line_width").as_dict()
    assert (said["min"], said["max"], said["description"]) == (0.5, 2.5, "Width of the ink.")
    assert knobs.label(tree.knobs["line_width"]) == "Line width (px)"
    assert tree["levels"] == 10
    assert isinstance(tree["levels"], int)


@pytest.mark.parametrize(("knob", "value"), [("line_width", 1.25), ("levels", 6), ("line_width", 0.3)])
def test_a_knob_that_is_turned_is_the_default(tree_of: Any, knob: str, value: float) -> None:
    graph = preset("abstraction")
    tree = tree_of(graph)
    tree[knob] = value
    graph["interface"][knob]["default"] = value
    assert json.dumps(graph_of(tree)) == json.dumps(graph)


def test_a_slider_sets_float32_and_the_file_has_few_digits(tree_of: Any) -> None:
    tree = tree_of(preset("abstraction"))
    tree["line_width"] = 0.8999999761581421  # what a slider makes of 0.9
    assert graph_of(tree)["interface"]["line_width"]["default"] == 0.9


def test_all_types_can_be_turned(tree_of: Any) -> None:
    tree = tree_of(
        with_knobs(
            on={"type": "bool", "default": True},
            form={"type": "enum", "default": "xdog", "choices": ["paper", "xdog"]},
            text={"type": "string", "default": "a"},
            ink={"type": "color", "default": [0, 0, 0]},
        )
    )
    tree["on"], tree["text"], tree["ink"] = False, "b", [0.5, 0.25, 2]
    tree["form"] = 0 if isinstance(tree["form"], int) else "paper"
    said = {name: knob["default"] for name, knob in graph_of(tree)["interface"].items()}
    assert said == {"on": False, "form": "paper", "text": "b", "ink": [0.5, 0.25, 2]}


def test_a_driven_parameter_says_so(tree_of: Any) -> None:
    graph = preset("abstraction")
    contrasts = dict(graph["nodes"]["lines"]["params"]["contrast"]["map"])  # by line_amount
    tree = tree_of(graph)
    node = node_of(tree, "lines")
    declared = declaration_of(node).all_params
    said = {
        name: node_drawing._driven_value(node, declared[name], drive)
        for name in ("sigma_c", "contrast")
        if (drive := driving.driven_by(node, declared[name]))
    }
    assert said == {"sigma_c": "1 (line_width)", "contrast": f"{contrasts[0.5]} (line_amount, mapped)"}
    tree["line_amount"] = 0.25
    assert node_drawing._driven_value(node, declared["contrast"], driving.driven_by(node, declared["contrast"])) == (
        f"{contrasts[0.25]} (line_amount, mapped)"
    )


def test_drive_and_stop(tree_of: Any) -> None:
    graph = with_knobs(width=WIDTH)
    tree = tree_of(graph)
    bpy.context.scene.flowabs_tree = tree
    bpy.ops.flowabs.drive(node="lines", parameter="sigma_c", knob="width", map="[[0.3, 1], [4, 2]]")
    params = {"sigma_c": {"from": "width", "map": [[0.3, 1], [4, 2]]}}
    assert graph_of(tree)["nodes"]["lines"]["params"] == params
    tree["width"] = 4.0
    bpy.ops.flowabs.drive(node="lines", parameter="sigma_c", knob="width", stop=True)
    assert graph_of(tree)["nodes"]["lines"]["params"] == {"sigma_c": 2}


def test_a_map_that_is_no_json_is_refused(tree_of: Any) -> None:
    bpy.context.scene.flowabs_tree = tree_of(with_knobs(width=WIDTH))
    with pytest.raises(RuntimeError, match="the map is not JSON"):
        bpy.ops.flowabs.drive(node="lines", parameter="sigma_c", knob="width", map="0 to 1")


def test_a_new_knob_of_any_parameter_is_valid(tree_of: Any) -> None:
    tree = tree_of(small())
    bpy.context.scene.flowabs_tree = tree
    node_of(tree, "lines").p_rho = 0.9
    for param in declaration_of(node_of(tree, "lines")).all_params:
        bpy.ops.flowabs.drive(node="lines", parameter=param, knob="+")
    graph = graph_of(tree)
    assert graph["interface"]["lines_rho"]["default"] == 0.9
    assert graph["nodes"]["lines"]["params"]["kernel"] == {"from": "lines_kernel"}
    assert not json.loads(tree.problems or "[]")
    assert not node_of(tree, "lines").problems or all(
        problem["warning"] for problem in json.loads(node_of(tree, "lines").problems)
    )


def test_edit_and_remove(tree_of: Any) -> None:
    tree = tree_of(with_knobs(width=WIDTH, drives={"sigma_c": {"from": "width"}}))
    bpy.context.scene.flowabs_tree = tree
    said = {"label": "Ink", "group": "", "help": "How wide.", "min": "0.5", "max": "3"}
    bpy.ops.flowabs.edit_knob(knob="width", name="ink width", **said)
    expected = {
        "type": "float",
        "default": 1.5,
        "unit": "px",
        "label": "Ink",
        "help": "How wide.",
        "min": 0.5,
        "max": 3,
    }
    assert graph_of(tree)["interface"] == {"ink_width": expected}
    assert graph_of(tree)["nodes"]["lines"]["params"] == {"sigma_c": {"from": "ink_width"}}
    bpy.ops.flowabs.edit_knob(knob="ink_width", remove=True)
    assert "interface" not in graph_of(tree) or graph_of(tree)["interface"] == {}
    assert graph_of(tree)["nodes"]["lines"]["params"] == {"sigma_c": 1.5}


def test_knobs_that_do_nothing_are_greyed(tree_of: Any) -> None:
    form = {"type": "enum", "default": "paper", "choices": ["paper", "xdog"]}
    strength = {"type": "float", "default": 20, "min": 1, "max": 100}
    tree = tree_of(with_knobs(form=form, p=strength, drives={"form": {"from": "form"}, "p": {"from": "p"}}))
    assert [knob.enabled for knob in tree.knobs] == [True, False]
    tree["form"] = 1 if isinstance(tree["form"], int) else "xdog"
    knob_watch.ask_after_move(tree)  # as the panel does when it is drawn
    assert bpy.app.timers.is_registered(knob_watch.update_moved)
    knob_watch.update_moved()
    assert [knob.enabled for knob in tree.knobs] == [True, True]
