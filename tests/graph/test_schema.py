"""The published schema and the validator agree, wherever a schema can say it at all."""

import json

import jsonschema
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes import graph
from flowabs_nodes.nodes import catalogue
from tests.graph.fakes import CATALOGUE, document, nodes
from tests.graph.test_safe_json import PLACES, json_values

SCHEMA = graph.schema(CATALOGUE)
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)


def changed(place, value):
    result = document()
    owner = result
    for key in place[:-1]:
        owner = owner.setdefault(key, {}) if isinstance(owner, dict) else owner[key]
    owner[place[-1]] = value
    return result


def test_it_is_a_schema():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.Draft202012Validator.check_schema(graph.schema())
    assert json.loads(json.dumps(SCHEMA)) == SCHEMA


@pytest.mark.parametrize("source", [document(), nodes(), {"format": "flowabs.graph/1", "nodes": {}}])
def test_good_graphs(source):
    VALIDATOR.validate(source)
    assert graph.check(source, CATALOGUE) == []


FIELD = ("nodes", "field", "params")
BAD = [
    (("format",), "flowabs.graph/2"),
    (("nane",), "x"),
    (("reference_height",), 0),
    (("reference_height",), "1080"),
    (("reference_size",), 1080),
    (("reference_size",), {}),
    (("reference_size",), {"shorter": 1080}),  # beside reference_height
    (("nodes",), []),
    (("nodes", "a b"), {"type": "read@1"}),
    (("nodes", "field", "type"), "flwo@1"),
    (("nodes", "field", "type"), "flow@2"),
    (("nodes", "field", "type"), "flow"),
    (("nodes", "field", "pos"), [0, 0]),
    (("nodes", "field", "inputs"), {}),
    (("nodes", "field", "inputs"), {"imgae": "plate"}),
    (("nodes", "field", "inputs", "image"), ["plate", "image"]),
    (("nodes", "field", "inputs", "image"), "plate.image.x"),
    (("nodes", "out", "inputs", "a b"), "plate"),
    (("nodes", "out", "inputs", "file"), "plate"),
    ((*FIELD, "raduis"), 1),
    ((*FIELD, "radius"), -1),
    ((*FIELD, "radius"), 101),
    ((*FIELD, "radius"), "5"),
    ((*FIELD, "radius"), None),
    ((*FIELD, "radius"), True),
    ((*FIELD, "radius"), {}),
    ((*FIELD, "radius"), {"form": "calm"}),
    ((*FIELD, "radius"), {"from": 1}),
    ((*FIELD, "radius"), {"from": "calm", "curve": {"1": 1}}),
    ((*FIELD, "radius"), {"from": "calm", "map": [[0, 1]]}),
    ((*FIELD, "radius"), {"from": "calm", "map": [[0, 1], [1, 101]]}),
    ((*FIELD, "radius"), {"from": "calm", "map": [[0, 1], [1]]}),
    ((*FIELD, "radius"), {"curve": {}}),
    ((*FIELD, "radius"), {"curve": {"one": 1}}),
    ((*FIELD, "radius"), {"curve": {"1": 101}}),
    ((*FIELD, "radius"), {"curve": {"1": None}}),
    ((*FIELD, "iterations"), 1.5),
    ((*FIELD, "kernel"), "half"),
    ((*FIELD, "kernel"), {"curve": {"1": 1}}),
    ((*FIELD, "kernel"), {"from": "calm", "map": [[0, 1], [1, 2]]}),
    ((*FIELD, "color"), 1),
    ((*FIELD, "reference"), "min"),
    ((*FIELD, "reference"), -1),
    (("nodes", "drawing", "params", "sigma"), 0),
    (("nodes", "drawing", "params", "contrast"), {"curve": {"1": None}}),
    (("nodes", "toon", "params", "ink"), [0, 0]),
    (("nodes", "toon", "params", "ink"), [0, 0, "0"]),
    (("nodes", "toon", "params", "mix"), 2),
    (("nodes", "out", "params", "file"), 1),
    (("interface", "a b"), {"type": "bool", "default": True}),
    (("interface", "calm", "type"), "number"),
    (("interface", "calm", "default"), "much"),
    (("interface", "calm", "lable"), "Calm"),
    (("interface", "calm", "choices"), ["a"]),
    (("interface", "passes", "default"), 1.5),
    (("interface", "how", "choices"), []),
    (("interface", "how", "choices"), ["a", "a"]),
    (("interface", "how", "min"), 1),
    (("interface", "tint", "default"), "red"),
    (("ui",), []),
]


@pytest.mark.parametrize(("place", "value"), BAD, ids=str)
def test_bad_graphs(place, value):
    source = changed(place, value)
    assert not VALIDATOR.is_valid(source)
    assert graph.check(source, CATALOGUE)


GOOD = [
    (("nodes", "drawing", "params", "contrast"), None),
    (("nodes", "drawing", "params", "contrast"), 2),
    ((*FIELD, "radius"), 5),
    ((*FIELD, "radius"), {"from": "width"}),
    ((*FIELD, "radius"), {"curve": {"-5": 0, "0": 1, "1001": 2.5}}),
    ((*FIELD, "reference"), "max"),
    ((*FIELD, "reference"), {"from": "passes"}),
    (("nodes", "field", "inputs", "image"), "plate.image"),
    (("nodes", "out", "params"), {}),
    (("ui", "anything"), {"at": ["all", {"": None}]}),
]


@pytest.mark.parametrize(("place", "value"), GOOD, ids=str)
def test_more_good_graphs(place, value):
    source = changed(place, value)
    VALIDATOR.validate(source)
    assert [each for each in graph.check(source, CATALOGUE) if not each.warning] == []


@settings(max_examples=200, deadline=None)
@given(place=st.sampled_from(PLACES), value=json_values)
def test_what_the_schema_refuses_the_validator_refuses(place, value):
    source = json.loads(json.dumps(changed(place, value)))
    text = json.dumps(source)
    if "NaN" in text or "Infinity" in text:
        return
    if not VALIDATOR.is_valid(source):
        assert graph.check(source, CATALOGUE)


def test_the_declaration_shows_in_it():
    radius = SCHEMA["$defs"]["node.flow"]["properties"]["params"]["properties"]["radius"]
    assert radius["description"] == "Radius."
    assert radius["default"] == 5.0
    assert radius["x-unit"] == "px"
    assert (radius["x-soft-min"], radius["x-soft-max"]) == (2, 15)
    assert radius["anyOf"][0] == {"type": "number", "minimum": 0, "maximum": 100}
    assert "mask" in SCHEMA["$defs"]["node.blur"]["properties"]["inputs"]["properties"]
    assert "mix" in SCHEMA["$defs"]["node.blur"]["properties"]["params"]["properties"]


def test_the_installed_nodes_are_all_in_the_schema():
    types = graph.schema()["$defs"]["node"]["properties"]["type"]["enum"]
    assert types == [node.name for node in catalogue().values()]
