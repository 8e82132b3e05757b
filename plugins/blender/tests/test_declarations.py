"""Node classes say what the declarations say: labels, ranges, units, help, choices, ports, categories."""

from typing import Any

import bpy
import pytest
from flowabs_blender import add_menu, sockets
from flowabs_blender.identifiers import node_id

from flowabs_nodes.choices import CATEGORIES
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.port_types import TYPES


@pytest.fixture
def node_of_type() -> Any:
    tree = bpy.data.node_groups.new("all", "FlowabsTree")
    return lambda type_name: tree.nodes.new(node_id(type_name))


@pytest.mark.parametrize("type_name", catalogue())
def test_a_node(type_name: str, node_of_type: Any) -> None:
    declaration, node = catalogue()[type_name], node_of_type(type_name)
    assert (node.bl_label, node.bl_description) == (declaration.label, declaration.help)
    assert [socket.port for socket in node.inputs] == list(declaration.all_inputs)
    assert [socket.port for socket in node.outputs] == list(declaration.all_outputs)
    for name, param in declaration.all_params.items():
        made = node.bl_rna.properties[f"p_{name}"]
        assert made.name == param.label
        assert param.help in made.description
        if param.unit and param.numeric:
            assert param.unit in made.description
        if param.numeric:
            assert made.is_animatable == param.animatable
            if param.soft:
                assert (made.soft_min, made.soft_max) == pytest.approx(param.soft)
            if param.min is not None and not param.above:
                assert made.hard_min == pytest.approx(param.min)
            if param.above:
                assert param.min < made.hard_min < param.min + 1e-40
            if param.max is not None:
                assert made.hard_max == pytest.approx(param.max)
        if param.kind == "enum":
            items = {item.identifier: (item.name, item.description) for item in made.enum_items}
            assert items == {
                word: (label, param.choice_meanings.get(word, "")) for word, label in param.choice_labels.items()
            }


def test_every_port_type_looks_like_itself() -> None:
    looks = [(sockets.LOOKS[kind][0]) for kind in TYPES]
    assert len(set(looks)) == len(TYPES)


def test_the_add_menu_has_every_node_once() -> None:
    found = add_menu.by_category()
    assert sorted(node.type for nodes in found.values() for node in nodes) == sorted(catalogue())
    assert list(found) == [category for category in CATEGORIES if category in found]
    for category in found:
        assert hasattr(bpy.types, add_menu._menu_id(category))
