import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.errors import ArgumentError
from tests.graph.fakes import CATALOGUE, document


@pytest.fixture
def toon():
    return graph.load(document(), CATALOGUE)


def problems(toon, **values):
    with pytest.raises(graph.GraphError) as caught:
        graph.override(toon, {name.replace("__", "."): value for name, value in values.items()})
    return [(problem.code, problem.pointer) for problem in caught.value.problems]


def test_knobs_and_parameters(toon):
    changed = graph.override(toon, {"width": 2, "field.iterations": 7, "toon.ink": [1, 0, 0], "plate.layer": "diffuse"})
    values = changed.values(1)
    assert values["drawing"]["sigma"] == 2
    assert values["field"]["iterations"] == 7
    assert values["toon"]["ink"] == (1, 0, 0)
    assert values["plate"]["layer"] == "diffuse"
    assert toon.document == document()
    assert toon.values(1)["drawing"]["sigma"] == 1


def test_the_document_says_what_was_set(toon):
    changed = graph.override(toon, {"width": 2, "soft.sigma": 3})
    assert changed.document["interface"]["width"]["default"] == 2
    assert changed.document["nodes"]["soft"]["params"] == {"sigma": 3}
    assert graph.load(changed.document, CATALOGUE).values(1) == changed.values(1)


def test_curves_and_knobs_can_be_set_too(toon):
    changed = graph.override(toon, {"drawing.sigma": {"curve": {1: 1, 3: 3}}, "soft.sigma": {"from": "width"}})
    assert changed.values(2)["drawing"]["sigma"] == 2
    assert changed.values(2)["soft"]["sigma"] == 1


def test_what_a_node_shares_with_others_can_be_set(toon):
    assert graph.override(toon, {"soft.mix": 0.25}).values(1)["soft"]["mix"] == 0.25


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("widht", 1, "unknown-param"),
        ("field", 1, "unknown-param"),
        ("feild.radius", 1, "unknown-node"),
        ("field.raduis", 1, "unknown-param"),
        ("field.", 1, "unknown-param"),
        ("", 1, "unknown-param"),
        (".", 1, "unknown-node"),
        ("width", 5, "out-of-range"),
        ("width", "wide", "wrong-type"),
        ("width", True, "wrong-type"),
        ("passes", 1.0, "wrong-type"),
        ("how", "half", "bad-value"),
        ("all", 1, "wrong-type"),
        ("field.radius", -1, "out-of-range"),
        ("field.radius", float("nan"), "bad-value"),
        ("field.radius", object(), "bad-value"),
        ("field.kernel", "half", "bad-value"),
        ("field.iterations", 2.5, "wrong-type"),
        ("plate.layer", 2, "wrong-type"),
        ("width", {"from": "calm"}, "wrong-type"),
    ],
)
def test_wrong_settings(toon, name, value, code):
    with pytest.raises(graph.GraphError) as caught:
        graph.override(toon, {name: value})
    (problem,) = caught.value.problems
    assert (problem.code, problem.pointer) == (code, f"--set {name}")


def test_hints(toon):
    for name, hint in (("widht", "'width'"), ("feild.radius", "'field'"), ("field.raduis", "'field.radius'")):
        with pytest.raises(graph.GraphError) as caught:
            graph.override(toon, {name: 1})
        assert hint in caught.value.problems[0].hint


def test_all_wrong_settings_at_once(toon):
    assert problems(toon, widht=1, width=100, field__radius=-1, soft__sigma=2) == [
        ("unknown-param", "--set widht"),
        ("out-of-range", "--set width"),
        ("out-of-range", "--set field.radius"),
    ]


def test_inside_a_value_the_place_goes_on(toon):
    assert problems(toon, field__radius={"curve": {"1": -1}}) == [("out-of-range", "--set field.radius/curve/1")]


def test_a_knob_without_a_range_stays_within_what_it_drives():
    source = document()
    source["interface"]["width"] = {"type": "float", "default": 1}
    assert problems(graph.load(source, CATALOGUE), width=500) == [("out-of-range", "--set width")]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("1.0", 1.0),
        ("-2e3", -2000.0),
        ("true", True),
        ("null", None),
        ("[1, 0, 0]", [1, 0, 0]),
        ('"2"', "2"),
        ("full", "full"),
        ("", ""),
        ("max", "max"),
        ("p99.5", "p99.5"),
        ("plate.####.exr", "plate.####.exr"),
        ("NaN", "NaN"),
        ("1e999", "1e999"),
        ('{"a": 1, "a": 2}', '{"a": 1, "a": 2}'),
        ("[" * 100_000, "[" * 100_000),
        ("/a/b\udcff", "/a/b\udcff"),
        ("1 2", "1 2"),
    ],
)
def test_from_the_command_line(text, value):
    result = graph.parse_setting(text)
    assert result == value
    assert type(result) is type(value)


def test_numbers_of_numpy_are_numbers(toon):
    curve = {"curve": {np.int64(1): np.float32(1), np.int32(3): 3}}
    values = {"width": np.float32(2), "passes": np.int64(3), "all": np.bool_(False), "tint": np.ones(3)}
    changed = graph.override(toon, {**values, "drawing.sigma": curve}).values(2)
    assert changed["field"]["iterations"] == 3
    assert changed["field"]["color"] is False
    assert changed["toon"]["ink"] == (1, 1, 1)
    assert changed["drawing"]["sigma"] == 2
    assert graph.override(toon, {"width": np.longdouble(2)}).values(2) == graph.override(toon, {"width": 2}).values(2)
    ones = graph.override(toon, {"tint": np.ones(3, np.longdouble)}).values(2)
    assert ones["toon"]["ink"] == (1, 1, 1)
    assert problems(toon, width=np.clongdouble(2)) == [("bad-value", "--set width")]
    assert problems(toon, passes=np.float64(2.5)) == [("wrong-type", "--set passes")]


@pytest.mark.parametrize("values", [["width=2"], "width=2", 3, {2: 1}])
def test_what_are_no_values(toon, values):
    with pytest.raises(ArgumentError, match="expected a dict such as"):
        graph.override(toon, values)


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("field", "field is a node: set field.PARAMETER"),
        ("plate", "plate is a node: set plate.PARAMETER"),
        ("Width", "did you mean 'width'?"),
        ("FIELD", "did you mean 'field'?"),
        ("Field.radius", "did you mean 'field'?"),
        ("field.RADIUS", "did you mean 'field.radius'?"),
        ("field.image", "image is an input: link it in the graph's file"),
    ],
)
def test_the_hint_names_what_was_meant(toon, name, hint):
    with pytest.raises(graph.GraphError) as caught:
        graph.override(toon, {name: 3})
    assert [problem.hint for problem in caught.value.problems] == [hint]


def test_a_setting_in_a_knobs_place_is_no_warning(toon):
    assert graph.override(toon, {"field.radius": 5}).warnings == ()
