import importlib
import pickle
import pkgutil

import pytest

import flowabs_nodes
from flowabs_nodes.errors import FlowabsError, closest, nearest


@pytest.mark.parametrize(
    ("name", "known", "right"),
    [
        ("sigma_C", ["sigma_m", "sigma_c", "sigma_s"], "sigma_c"),
        ("SIGMA_M", ["sigma_c", "sigma_m"], "sigma_m"),
        ("ETF@1", ["etf@1", "lic@1"], "etf@1"),
        ("fig1", ["fig01", "fig10", "fig21"], "fig01"),
        ("Fig007", ["fig06", "fig07", "fig17"], "fig07"),
        ("shot10", ["shot0010", "shot0100"], "shot0010"),
        ("srgb", ["sRGB", "lin_rec709"], "sRGB"),
        ("brigth", ["bright", "plate"], "bright"),
        ("line-width", ["line_amount", "line_width"], "line_width"),
        ("Line Width", ["linewidths", "line_width"], "line_width"),
        ("ARRI_LogC3", ["ARRI LogC4", "arri_logc4", "arri_logc3_ei800"], "arri_logc3_ei800"),
        ("abstr", ["astra", "abstraction"], "abstraction"),
        ("zzz", ["bright"], None),
    ],
)
def test_the_nearest_name_is_found_case_and_zeros_aside(name, known, right):
    assert closest(name, known) == right
    assert nearest(name, known) == (f"did you mean {right!r}?" if right else "known: bright")


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ("radius: expected a number", "node n: radius: expected a number"),
        ("radius['x']: expected a number", "node n: radius['x']: expected a number"),
        ("radius_2: expected a number", "node n: parameter radius: radius_2: expected a number"),
        ("5 is too much", "node n: parameter radius: 5 is too much"),
        ("radius 'x' is not in the file", "node n: radius 'x' is not in the file"),
        ("node 'n' has none", "parameter radius: node 'n' has none"),
        ("node 'n2' has none", "node n: parameter radius: node 'n2' has none"),
    ],
)
def test_node_and_parameter_are_named_once(message, text):
    assert str(FlowabsError(message, node="n", parameter="radius")) == text


def test_a_message_may_begin_with_any_word_where_no_place_is_known():
    assert str(FlowabsError("None is no number")) == "None is no number"


def every_error():
    """Return every class of the family that the package declares."""
    for module in pkgutil.walk_packages(flowabs_nodes.__path__, "flowabs_nodes."):
        if module.name != "flowabs_nodes.__main__":
            importlib.import_module(module.name)
    found, waiting = [], [FlowabsError]
    while waiting:
        found.append(waiting.pop())
        waiting += found[-1].__subclasses__()
    return [each for each in found if each.__module__.startswith("flowabs_nodes.")]


def test_every_error_can_travel_to_another_process_however_it_is_made():
    classes = every_error()
    assert len(classes) > 8
    for each in classes:
        error = each.__new__(each, "went wrong")
        FlowabsError.__init__(error, "went wrong", code="a-code", hint="try again", file="a.exr", frame=7)
        error.problems = error.more = ()  # what some classes have beside
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is each
        assert (str(again), again.to_dict(), again.more) == (str(error), error.to_dict(), error.more)
