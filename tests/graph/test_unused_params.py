"""What a graph sets to no effect is a warning: a parameter that others disable, a knob that changes nothing."""

import dataclasses

import jsonschema
import pytest

from flowabs_nodes import graph
from flowabs_nodes.graph.overrides import override
from flowabs_nodes.graph.problems import Problems
from flowabs_nodes.graph.schema import schema
from flowabs_nodes.graph.validate import validate
from flowabs_nodes.nodes.declare import Param
from tests.graph import fakes
from tests.graph.fakes import CATALOGUE

STYLED = dataclasses.replace(
    CATALOGUE["lines"],
    params=(
        Param.enum("style", "plain", ("plain", "soft", "hard"), help="Style."),
        Param.bool("tinted", False, help="Tinted."),
        Param.float("ramp", 1.0, enabled_when={"style": ("soft", "hard")}, help="Ramp."),
        Param.float("tint", 1.0, enabled_when={"style": ("hard",), "tinted": (True,)}, help="Tint."),
    ),
)
NODES = CATALOGUE | {"lines": STYLED}


def document(interface=None, **params):
    return {
        "format": "flowabs.graph/1",
        "interface": interface or {},
        "nodes": {
            "plate": {"type": "read@1"},
            "field": {"type": "flow@1", "inputs": {"image": "plate"}},
            "ink": {"type": "lines@1", "inputs": {"image": "plate", "flow": "field"}, "params": params},
        },
    }


def warnings(source):
    found = graph.check(source, NODES)
    assert all(problem.warning and problem.code == "unused-param" for problem in found)
    return [problem.pointer for problem in found]


def knob(value):
    return {"look": {"type": "enum", "default": value, "choices": ["plain", "soft"]}}


@pytest.mark.parametrize(
    ("params", "unused"),
    [
        ({}, []),
        ({"style": "plain"}, []),
        ({"ramp": 2}, ["ramp"]),
        ({"ramp": 1.0}, ["ramp"]),  # set, if to its default
        ({"style": "plain", "ramp": 2}, ["ramp"]),
        ({"style": "soft", "ramp": 2}, []),
        ({"style": "hard", "ramp": 2, "tint": 2}, ["tint"]),
        ({"style": "soft", "tinted": True, "tint": 2}, ["tint"]),
        ({"style": "hard", "tinted": True, "ramp": 2, "tint": 2}, []),
        ({"ramp": {"curve": {"1": 1, "2": 2}}}, ["ramp"]),
    ],
)
def test_who_is_warned_of(params, unused):
    assert warnings(document(**params)) == [f"/nodes/ink/params/{name}" for name in unused]


def test_the_warning_says_what_disables_it_and_what_to_do():
    (problem,) = graph.check(document(ramp=2.5), NODES)
    assert problem.found == 'ramp 2.5, which does nothing beside style "plain"'
    assert problem.expected == 'style "soft" or "hard" for ramp'
    assert problem.hint == "leave ramp out, or change what disables it"
    (problem,) = graph.check(document(tint={"curve": {"1": 1}}), NODES)
    assert problem.found == 'tint, which does nothing beside style "plain" and tinted false'
    assert problem.expected == 'style "hard" and tinted true for tint'


def test_a_knob_counts_at_the_value_where_it_stands():
    driven = {"style": {"from": "look"}, "ramp": 2}
    assert warnings(document(knob("soft"), **driven)) == []
    (problem,) = graph.check(document(knob("plain"), **driven), NODES)
    assert problem.hint == "leave ramp out, or turn the knob 'look'"


def test_a_setting_from_outside_is_judged_too_and_named():
    loaded = graph.load(document(knob("soft"), style={"from": "look"}, ramp=2), NODES)
    assert loaded.warnings == ()
    (problem,) = override(loaded, {"look": "plain"}).warnings
    assert problem.pointer == "/nodes/ink/params/ramp"
    (problem,) = override(graph.load(document(), NODES), {"ink.ramp": 3}).warnings
    assert problem.pointer == "--set ink.ramp"


def test_what_follows_from_a_mistake_is_not_reported():
    (problem,) = graph.check(document(style="sotf", ramp=2), NODES)
    assert problem.code == "bad-value"


def test_a_graph_with_more_warnings_than_are_listed_is_good():
    many = document()
    many["nodes"] |= {f"ink{i}": many["nodes"]["ink"] | {"params": {"ramp": 2, "tint": 2}} for i in range(40)}
    problems = Problems()
    problems.most = 50
    assert validate(many, NODES, problems) is not None
    assert len(problems.found) == 50


def test_the_schema_takes_such_a_graph_and_says_beside_what_each_does_something():
    made = schema(NODES)
    jsonschema.Draft202012Validator(made).validate(document(ramp=2, tint=2))
    params = made["$defs"]["node.lines"]["properties"]["params"]["properties"]
    assert params["tint"]["x-enabled-when"] == {"style": ["hard"], "tinted": [True]}
    assert "x-enabled-when" not in params["style"]


def test_xdog_in_a_paper_drawing():
    source = document()
    source["nodes"]["field"]["type"] = "etf@1"
    source["nodes"]["ink"] |= {"type": "fdog@1", "params": {"phi": 0.1, "rho": 0.9}}
    (problem,) = graph.check(source)
    assert (problem.code, problem.pointer) == ("unused-param", "/nodes/ink/params/phi")
    source["nodes"]["ink"]["params"]["form"] = "xdog"
    (problem,) = graph.check(source)
    assert problem.pointer == "/nodes/ink/params/rho"


def test_a_knob_that_drives_nothing():
    whole = fakes.document()
    spare = {"type": "float", "default": 1}
    whole["interface"] |= {"spare": spare}
    found = graph.check(whole, fakes.CATALOGUE)
    assert [(each.code, each.pointer, each.warning) for each in found] == [("unused-knob", "/interface/spare", True)]
    assert "drives nothing" in found[0].found
    whole["nodes"]["field"]["params"]["radius"] = {"from": "spare"}
    assert [each.pointer for each in graph.check(whole, fakes.CATALOGUE)] == ["/interface/calm"]


@pytest.mark.parametrize(
    ("node", "params", "words"),
    [
        ("field", {"radius": {"from": "spare", "map": [[0, 5], [1, 5]]}}, "field.radius is 5 everywhere on its map"),
        ("field", {"iterations": {"from": "spare", "map": [[0, 3], [1, 3]]}}, "field.iterations is 3 everywhere"),
        ("lonely", {"radius": {"from": "spare"}}, "nothing needs lonely, of which it drives radius"),
        (
            "lonely",
            {key: {"from": "spare"} for key in ("radius", "reference")},
            "drives radius; nothing needs lonely, of",
        ),
        ("lonely", {"iterations": {"from": "spare", "map": [[0, 3], [1, 4]]}}, "of which it drives iterations"),
        ("field", {"radius": {"from": "spare", "map": [[0, 5], [1, 6]]}}, ""),
        ("field", {"iterations": {"from": "spare", "map": [[0, 3], [1, 4]]}}, ""),
        ("toon", {"mix": {"from": "spare"}}, ""),
    ],
)
def test_a_knob_that_changes_nothing(node, params, words):
    whole = fakes.document()
    whole["interface"]["spare"] = {"type": "float", "default": 1}
    whole["nodes"]["lonely"] = {"type": "flow@1", "inputs": {"image": "plate"}}
    whole["nodes"][node].setdefault("params", {}).update(params)
    found = [each for each in graph.check(whole, fakes.CATALOGUE) if each.pointer == "/interface/spare"]
    assert [(each.code, each.warning) for each in found] == [("unused-knob", True)] * bool(words)
    assert all(words in each.found for each in found)


def test_a_setting_of_a_knob_that_drives_nothing_is_told():
    whole = fakes.document()
    whole["interface"]["spare"] = {"type": "float", "default": 1}
    (problem,) = override(graph.load(whole, fakes.CATALOGUE), {"spare": 2}).warnings
    assert problem.code == "unused-knob"


@pytest.mark.parametrize("written", [3.0, -0.0, 1e1])
def test_a_whole_number_is_written_without_a_fraction(written):
    places = {
        "/nodes/field/params/iterations": written,
        "/nodes/field/params/iterations/map/1/1": {"from": "width", "map": [[0, 1], [1, written]]},
        "/nodes/field/params/iterations/curve/7": {"curve": {"1": 1, "7": written}},
    }
    for place, value in places.items():
        whole = fakes.document()
        whole["nodes"]["field"]["params"]["iterations"] = value
        assert wrong(whole) == [("wrong-type", place, str(written), f"write {int(written)}")]
    for key in ("default", "min", "max"):
        whole = fakes.document()
        whole["interface"]["passes"] = {"type": "int", "default": 2} | {key: written}
        assert wrong(whole) == [("wrong-type", f"/interface/passes/{key}", str(written), f"write {int(written)}")]
    assert "3.0" in graph.schema(fakes.CATALOGUE)["$comment"]


@pytest.mark.parametrize("written", [2.5, 1e300, True, "3", None])
def test_what_is_no_whole_number_has_no_such_hint(written):
    whole = fakes.document()
    whole["nodes"]["field"]["params"]["iterations"] = written
    ((code, _, _, hint),) = wrong(whole)
    assert (code, hint) == ("wrong-type", "")


def wrong(whole):
    """Return code, place, what was found and the hint of each error in a graph."""
    found = [each for each in graph.check(whole, fakes.CATALOGUE) if not each.warning]
    return [(each.code, each.pointer, each.found, each.hint) for each in found]
