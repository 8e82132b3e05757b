"""Displays and views that a graph names are looked up before a run."""

import pytest

from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.display_names import wrong_views
from flowabs_nodes.errors import ColorError
from tests.color.configs import with_displays


def graph(knob=None, **params):
    nodes = {"plate": {"type": "read@1"}, "out": {"type": "write@1", "inputs": {"image": "plate"}, "params": params}}
    interface = {} if knob is None else {"look": {"type": "string", "default": knob}}
    return load_graph({"format": "flowabs.graph/1", "interface": interface, "nodes": nodes})


@pytest.mark.parametrize(
    "params", [{}, {"view": "default"}, {"display": "default"}, {"display": "Display P3 - Display", "view": "Raw"}]
)
def test_names_that_the_config_has(params):
    assert wrong_views(graph(**params), None) == []


@pytest.mark.parametrize(
    ("params", "place", "expected", "hint"),
    [
        ({"view": "Rawr"}, "/nodes/out/params/view", "'Un-tone-mapped', 'Raw'", "did you mean 'Raw'?"),
        ({"display": "sRGB"}, "/nodes/out/params/display", "one of 'sRGB - Display', 'Display P3", "'sRGB - Display'?"),
        ({"view": "Raw", "colorspace": "sRGB"}, "/nodes/out/params/colorspace", '"plate" beside a display', ""),
    ],
)
def test_names_that_it_has_not(params, place, expected, hint):
    (problem,) = wrong_views(graph(**params), None)
    assert (problem.code, problem.pointer) == ("bad-value", place)
    assert expected in problem.expected
    assert hint in problem.hint
    assert wrong_views(graph(**params), None, {"plate"}) == []  # out is not to run
    assert wrong_views(graph(**params), None, {"plate", "out"}) == [problem]


def test_a_knobs_value_is_pointed_at():
    (problem,) = wrong_views(graph(knob="Rawr", view={"from": "look"}), None)
    assert problem.pointer == "/interface/look/default"


def test_the_config_of_the_run_counts(tmp_path):
    ocio = with_displays(tmp_path / "studio.ocio")
    assert wrong_views(graph(view="film"), ocio) == []
    (problem,) = wrong_views(graph(view="Raw"), ocio)
    assert problem.expected == "one of 'film', 'as numbers'"


def test_a_config_is_read_only_where_it_is_needed():
    assert wrong_views(graph(), "no such config") == []
    with pytest.raises(ColorError):
        wrong_views(graph(view="default"), "no such config")
