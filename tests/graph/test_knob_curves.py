"""Knobs that stand at a curve: ``"default": {"curve": {frame: value}}``, in a file or from outside."""

import dataclasses

import jsonschema
import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.engine.keys import node_key
from flowabs_nodes.nodes.declare import Param
from tests.graph.fakes import CATALOGUE, document


def with_knob(knob, value, **keys):
    """The graph of something of everything, one knob at another value."""
    source = document()
    source["interface"][knob] |= {"default": value} | keys
    return source


def found(source, catalogue=CATALOGUE):
    return [(problem.code, problem.pointer) for problem in graph.check(source, catalogue)]


def at(source, frame, node, param):
    return graph.load(source, CATALOGUE).values(frame)[node][param]


@pytest.mark.parametrize(("frame", "width"), [(-5, 1), (1, 1), (12, 2), (23, 3), (99, 3)])
def test_a_parameter_follows_its_knob(frame, width):
    assert at(with_knob("width", {"curve": {"1": 1, "23": 3}}), frame, "drawing", "sigma") == width


def test_maps_are_of_the_value_on_the_frame():
    source = with_knob("calm", {"curve": {"1": 0, "5": 1}})
    assert [at(source, frame, "field", "radius") for frame in (1, 2, 3, 4, 5)] == [5, 5.5, 6, 8, 10]


def test_whole_numbers_round():
    source = with_knob("passes", {"curve": {"1": 0, "5": 3}})
    passes = [at(source, frame, "field", "iterations") for frame in (1, 2, 3, 4, 5)]
    assert passes == [0, 1, 2, 2, 3]
    assert all(isinstance(each, int) for each in passes)


@pytest.mark.parametrize(
    ("knob", "value", "code", "pointer"),
    [
        ("width", {"curve": {"1": 1, "24": 9}}, "out-of-range", "/curve/24"),
        ("width", {"curve": {"1": "1"}}, "wrong-type", "/curve/1"),
        ("width", {"curve": {"1": None}}, "wrong-type", "/curve/1"),
        ("width", {"curve": {"one": 1}}, "bad-value", "/curve/one"),
        ("width", {"curve": {"1.5": 1}}, "bad-value", "/curve/1.5"),
        ("width", {"curve": {}}, "bad-value", "/curve"),
        ("width", {"curve": [1, 2]}, "wrong-type", "/curve"),
        ("width", {"curve": {"1": 1}, "map": [[0, 1], [1, 2]]}, "unknown-key", "/map"),
        ("width", {"crv": {"1": 1}}, "wrong-type", ""),
        ("width", {"from": "calm"}, "wrong-type", ""),
        ("passes", {"curve": {"1": 1, "2": 1.5}}, "wrong-type", "/curve/2"),
        ("passes", {"curve": {"1": 1, "2": 2.0}}, "wrong-type", "/curve/2"),
        ("how", {"curve": {"1": "full"}}, "wrong-type", "/curve"),
        ("tint", {"curve": {"1": [0, 0, 0]}}, "wrong-type", "/curve"),
        ("words", {"curve": {"1": "hello"}}, "wrong-type", "/curve"),
        ("all", {"curve": {"1": True}}, "wrong-type", "/curve"),
    ],
)
def test_values_are_checked_like_literals(knob, value, code, pointer):
    source = with_knob(knob, value)
    assert found(source) == [(code, f"/interface/{knob}/default{pointer}")]
    with pytest.raises(graph.GraphError) as caught:
        graph.override(graph.load(document(), CATALOGUE), {knob: value})
    assert [(each.code, each.pointer) for each in caught.value.problems] == [(code, f"--set {knob}{pointer}")]
    if value != {"curve": {"1": 1, "24": 9}} and value != {"curve": {"1": 1, "2": 2.0}}:  # what no schema can say
        assert not jsonschema.Draft202012Validator(graph.schema(CATALOGUE)).is_valid(source)


def test_each_key_stays_within_what_the_knob_drives():
    source = with_knob("width", {"curve": {"1": 1, "24": 0}})
    source["interface"]["width"] = {"type": "float", "default": {"curve": {"1": 1, "24": 0}}}
    assert found(source) == [("out-of-range", "/interface/width/default/curve/24")]


def test_a_number_that_is_the_same_on_every_frame_takes_no_knob_that_moves():
    steady = dataclasses.replace(
        CATALOGUE["flow"],
        params=(*CATALOGUE["flow"].params[:4], Param.int("reference", 1, animatable=False, help="Steady.")),
    )
    for value in ({"from": "passes"}, {"from": "calm", "map": [[0, 0], [1, 9]]}):
        source = document()
        source["nodes"]["field"]["params"]["reference"] = value
        assert found(source, CATALOGUE | {"flow": steady}) == []
        knob = value["from"]
        source["interface"][knob]["default"] = {"curve": {"1": 0, "2": 1}}
        (problem,) = graph.check(source, CATALOGUE | {"flow": steady})
        assert (problem.code, problem.pointer) == ("wrong-type", f"/interface/{knob}/default/curve")
        assert problem.expected == "one value: field.reference is the same on every frame"


def test_nor_does_what_is_no_number_in_the_declaration():
    source = with_knob("calm", {"curve": {"1": 0, "2": 1}})
    source["nodes"]["field"]["params"]["reference"] = {"from": "calm"}
    assert found(source) == [("wrong-type", "/interface/calm/default/curve")]


def test_the_schema_knows_curves():
    validator = jsonschema.Draft202012Validator(graph.schema(CATALOGUE))
    for knob, curve in (("width", {"1001": 1, "-3": 2.5}), ("passes", {"1": 1, "9": 2})):
        source = with_knob(knob, {"curve": curve})
        assert found(source) == []
        validator.validate(source)


def test_from_outside_with_keys_of_any_kind():
    toon = graph.load(document(), CATALOGUE)
    for keys in ((1, 3), ("1", "3"), (np.int64(1), np.int64(3))):
        moved = graph.override(toon, {"width": {"curve": {keys[0]: 1, keys[1]: np.float32(3)}}})
        assert moved.values(2)["drawing"]["sigma"] == 2
        assert moved.document["interface"]["width"]["default"] == {"curve": {"1": 1, "3": 3}}
        assert graph.override(moved, {"width": 2}).values(3)["drawing"]["sigma"] == 2
    assert graph.override(toon, {"width": graph.parse_setting('{"curve": {"1": 1, "3": 3}}')}).values(2) == (
        graph.override(toon, {"width": 2}).values(2)
    )


def test_a_key_is_that_of_the_value_on_the_frame():
    plain, still, moving = (
        graph.load(with_knob("width", value), CATALOGUE)
        for value in (2, {"curve": {"1": 2, "9": 2.0}}, {"curve": {"1": 1, "3": 3}})
    )

    def key(toon, frame):
        return node_key(CATALOGUE["lines"], toon.values(frame)["drawing"], {})

    assert key(still, 5) == key(plain, 5) == key(moving, 2)
    assert len({key(moving, frame) for frame in range(5)}) == 3
