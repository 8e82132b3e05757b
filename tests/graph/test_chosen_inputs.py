"""What a node chooses among its inputs must be linked, at every value that its knobs and curves give."""

from dataclasses import replace

import pytest

from flowabs_nodes import graph
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.graph.fakes import CATALOGUE

PICK = Node(
    "pick",
    1,
    "Picks.",
    (Port("left", "any", "."), Port("right", "any", ".", optional=True)),
    (Port("image", "=left|right", "."),),
    (Param.bool("mirrored", False, help="."), Param.float("at", 0.0, min=0, max=1, help=".")),
    CATALOGUE["read"].run,
    needs=lambda params: ("right",) if params["mirrored"] or params["at"] > 0.5 else ("left",),
)
NODES = CATALOGUE | {"pick": PICK}


def pointers(inputs=("left",), interface=None, **params):
    document = {
        "format": "flowabs.graph/1",
        "interface": interface or {},
        "nodes": {
            "plate": {"type": "read@1"},
            "one": {"type": "pick@1", "inputs": dict.fromkeys(inputs, "plate"), "params": params},
        },
    }
    problems = [each for each in graph.check(document, NODES) if not each.warning]
    assert {each.code for each in problems} <= {"missing-input"}
    return [each.pointer for each in problems]


@pytest.mark.parametrize("params", [{}, {"at": 0.5}, {"at": {"curve": {"1": 0, "9": 0.5}}}])
def test_what_is_chosen_is_linked(params):
    assert pointers(**params) == []


@pytest.mark.parametrize("params", [{"mirrored": True}, {"at": 0.6}, {"at": {"curve": {"1": 0, "9": 1}}}])
def test_what_is_chosen_is_not_linked(params):
    assert pointers(**params) == ["/nodes/one/inputs/right"]
    assert pointers(("left", "right"), **params) == []


@pytest.mark.parametrize(("stands", "found"), [(False, []), (True, ["/nodes/one/inputs/right"])])
def test_a_knob_counts_where_it_stands(stands, found):
    knob = {"turned": {"type": "bool", "default": stands, "help": "."}}
    assert pointers(interface=knob, mirrored={"from": "turned"}) == found


def test_a_node_that_needs_all_is_not_asked():
    assert replace(PICK, needs=None).needed(("left",), {}) == ("left",)


@pytest.mark.parametrize("error", [ZeroDivisionError("no"), SystemExit(2), FlowabsError("no")])
def test_a_node_that_cannot_say_is_named(error):
    def fail(params):
        raise error

    document = {
        "format": "flowabs.graph/1",
        "nodes": {"plate": {"type": "read@1"}, "one": {"type": "pick@1", "inputs": {"left": "plate"}}},
    }
    with pytest.raises(FlowabsError) as failure:
        graph.check(document, NODES | {"pick": replace(PICK, needs=fail)})
    assert failure.value.node == "one"
