"""Older files stay readable: the mechanism, on a node at version 3 and on a format that is not there yet."""

import dataclasses

import pytest

from flowabs_nodes import graph
from flowabs_nodes.graph.problems import Problems
from flowabs_nodes.graph.upgrade import upgrade_format
from flowabs_nodes.nodes.declare import Param
from tests.graph.fakes import CATALOGUE, document, nodes


def _from_1_to_2(params):
    """The radius was called size."""
    if "size" in params:
        params["radius"] = params.pop("size")
    return params


def _from_2_to_3(params):
    """The radius was a diameter; passes are new, and were 1."""
    if isinstance(params.get("radius"), int | float):
        params["radius"] = params["radius"] / 2
    return params | {"passes": 1}


FLOW_3 = dataclasses.replace(
    CATALOGUE["flow"],
    version=3,
    params=(
        Param.float("radius", 5.0, min=0, max=100, help="Radius."),
        Param.int("passes", 2, min=0, max=10, help="Passes."),
    ),
    upgrades={1: _from_1_to_2, 2: _from_2_to_3},
)
NEWER = CATALOGUE | {"flow": FLOW_3}


def load(type, **params):
    return graph.load(nodes(field={"type": type, "inputs": {"image": "plate"}, "params": params}), NEWER)


def test_from_the_first_version_step_by_step():
    loaded = load("flow@1", size=12)
    assert loaded.values(1)["field"] == {"radius": 6.0, "passes": 1}
    assert loaded.notes == ("field: flow@1 read as flow@3",)
    assert loaded.document["nodes"]["field"]["type"] == "flow@3"
    assert loaded.document["nodes"]["field"]["params"] == {"radius": 6.0, "passes": 1}


def test_from_a_version_between():
    assert load("flow@2", radius=12).values(1)["field"] == {"radius": 6.0, "passes": 1}


def test_the_newest_version_stays_as_it_is():
    loaded = load("flow@3", radius=12)
    assert loaded.values(1)["field"] == {"radius": 12.0, "passes": 2}
    assert loaded.notes == ()


def test_without_parameters_the_old_defaults_hold():
    source = nodes(field={"type": "flow@1", "inputs": {"image": "plate"}})
    assert graph.load(source, NEWER).values(1)["field"]["passes"] == 1


def test_an_upgraded_graph_needs_no_upgrade():
    loaded = load("flow@1", size=12)
    again = graph.load(loaded.document, NEWER)
    assert again.notes == ()
    assert again.values(1) == loaded.values(1)


def test_settings_are_those_of_the_newest_version_and_the_note_stays():
    changed = graph.override(load("flow@1", size=12), {"field.radius": 4})
    assert changed.values(1)["field"]["radius"] == 4
    assert changed.notes == ("field: flow@1 read as flow@3",)


def found(type, declaration=FLOW_3, **params):
    source = nodes(field={"type": type, "inputs": {"image": "plate"}, "params": params})
    return [(problem.code, problem.pointer) for problem in graph.check(source, CATALOGUE | {"flow": declaration})]


def test_a_newer_version_cannot_be_read():
    assert found("flow@4", anything=1) == [("newer-version", "/nodes/field/type")]


def test_a_version_without_an_upgrade_cannot_be_read():
    assert found("flow@1", dataclasses.replace(FLOW_3, upgrades={2: _from_2_to_3})) == [
        ("unknown-type", "/nodes/field/type")
    ]


@pytest.mark.parametrize("error", [KeyError, TypeError, ValueError, ZeroDivisionError])
def test_an_upgrade_that_stumbles_over_a_value_is_a_problem(error):
    def stumble(params):
        raise error("size")

    declaration = dataclasses.replace(FLOW_3, version=2, upgrades={1: stumble})
    assert found("flow@1", declaration, size=12) == [("bad-value", "/nodes/field/params")]


def test_values_are_checked_after_the_upgrade():
    assert found("flow@1", size=1000) == [("out-of-range", "/nodes/field/params/radius")]


def test_formats_are_upgraded_step_by_step():
    steps = {
        1: lambda document: document | {"format": "flowabs.graph/2", "two": True},
        2: lambda document: document | {"format": "flowabs.graph/3", "three": True},
    }
    problems, notes = Problems(), []
    result = upgrade_format(document(), problems, notes, newest=3, upgrades=steps)
    assert result == document() | {"format": "flowabs.graph/3", "two": True, "three": True}
    assert notes == ["format 1 read as 3"]
    assert upgrade_format(result | {"format": "flowabs.graph/4"}, problems, notes, newest=3, upgrades=steps) is None
    assert [problem.code for problem in problems.found] == ["newer-version"]


def test_of_a_newer_format_nothing_else_is_said():
    problems = graph.check({"format": "flowabs.graph/2", "noodles": []}, CATALOGUE)
    assert [problem.code for problem in problems] == ["newer-version"]
