import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes import graph
from flowabs_nodes.graph.values import Curve, FromKnob, Literal, interpolate
from tests.graph.fakes import CATALOGUE, document

numbers = st.floats(-1e300, 1e300)


def test_literal():
    assert Literal([1, 2]).at(7, {}) == [1, 2]


def test_a_curve_is_linear_between_its_keys_and_held_beyond():
    curve = Curve(((1001, 1.0), (1011, 2.0), (1012, 0.0)))
    assert [curve.at(frame, {}) for frame in (-5, 1001, 1006, 1011, 1012, 2000)] == [1.0, 1.0, 1.5, 2.0, 0.0, 0.0]
    assert Curve(((5, 3),)).at(1, {}) == 3


def test_whole_numbers_round_with_the_half_upwards():
    curve = Curve(((0, 0), (4, 2)), whole=True)
    assert [curve.at(frame, {}) for frame in range(5)] == [0, 1, 1, 2, 2]
    assert [Curve(((0, -2), (4, 0)), whole=True).at(frame, {}) for frame in range(5)] == [-2, -1, -1, 0, 0]
    assert isinstance(curve.at(1, {}), int)


def test_a_knob_as_it_is_and_through_a_map():
    assert FromKnob("k").at(1, {"k": "word"}) == "word"
    mapped = FromKnob("k", ((0, 8.5), (0.5, 1.5), (1, 0.27)))
    assert [mapped.at(1, {"k": value}) for value in (-1, 0, 0.25, 0.5, 1, 2)] == [8.5, 8.5, 5.0, 1.5, 0.27, 0.27]
    assert FromKnob("k", ((0, 0), (1, 4)), whole=True).at(1, {"k": 0.4}) == 2


@given(st.dictionaries(st.integers(-1000, 1000), numbers, min_size=1), st.floats(-2000, 2000))
def test_interpolation_stays_within_its_keys(keys, x):
    points = sorted(keys.items())
    value = interpolate(points, x)
    assert math.isfinite(value)
    assert min(keys.values()) <= value <= max(keys.values())
    assert all(interpolate(points, key) == y for key, y in points)


def test_values_of_a_graph():
    values = graph.load(document(), CATALOGUE).values(1006)
    assert values["field"] == {
        "radius": 6.0,
        "iterations": 2,
        "kernel": "full",
        "color": True,
        "reference": 16,
    }
    assert values["drawing"] == {"sigma": 1.0, "contrast": 1.5}
    assert values["toon"] == {"ink": (0.0, 0.1, 0.0), "note": "hello", "mix": 0.5}
    assert values["soft"] == {"sigma": 1.0, "mix": 1.0}
    assert values["plate"] == {"file": "plate.####.exr", "layer": ""}
    assert isinstance(values["drawing"]["contrast"], float)


def test_defaults_and_a_file_that_is_not_set():
    values = graph.load({"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}}}, CATALOGUE).values(1)
    assert values == {"plate": {"layer": ""}}


@pytest.mark.parametrize("frame", [1001, 1011])
def test_an_int_in_a_float_parameter_becomes_a_float(frame):
    assert isinstance(graph.load(document(), CATALOGUE).values(frame)["drawing"]["contrast"], float)
