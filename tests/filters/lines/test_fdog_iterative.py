import inspect
import time
import weakref

import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import fdog, fdog_iterative, threshold
from flowabs_nodes.filters.lines.fdog import Detector
from flowabs_nodes.filters.lines.fdog_iterative import Passes
from tests.filters.flows import cases
from tests.naive import fdog as naive

DEFAULTS = {
    name: each.default
    for name, each in inspect.signature(fdog_iterative).parameters.items()
    if each.default is not inspect.Parameter.empty
}

SOFT = {"rho": 1.0, "contrast": 1.5, "softness": 4.0}


@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_section_3_2_in_float64(name):
    image, flow = cases()[name]
    lines, response = fdog_iterative(image[..., 0], flow)
    expected_lines, expected = naive.fdog_iterative(image[..., 0], flow, 3)
    assert (lines == expected_lines).mean() > 0.999
    np.testing.assert_allclose(np.median(abs(response - expected)), 0, atol=1e-4)


@pytest.mark.parametrize(
    "parameters", [{"iterations": 2}, {"iterations": 3, "pre_blur": 0.8, "color_weight": 0.5, "color_sign": True}]
)
def test_soft_lines_from_colour(parameters):
    image, flow = cases()["photo"]
    lines, response = fdog_iterative(image, flow, **SOFT, **parameters)
    expected_lines, expected = naive.fdog_iterative(image, flow, **SOFT, **parameters)
    np.testing.assert_allclose(response, expected, rtol=0, atol=1e-3)
    np.testing.assert_allclose(lines, expected_lines, rtol=0, atol=1e-3)


def test_one_pass_is_fdog_and_threshold():
    image, flow = cases()["photo"]
    lines, response = fdog_iterative(image, flow, 2.0, 1.2, 0.98, 0.5, "full", "nearest", 0.6, None, 1.0, 1)
    np.testing.assert_array_equal(response, fdog(image, flow, 2.0, 1.2, 0.98, 0.5, "full", "nearest"))
    np.testing.assert_array_equal(lines, threshold(response, 0.6, None, 1.0))


def test_each_pass_draws_over_the_original():
    image, flow = cases()["photo"]
    first, _ = fdog_iterative(image, flow, **SOFT, iterations=1)
    second, _ = fdog_iterative(image, flow, **SOFT, iterations=2)
    again = threshold(fdog(image * first[..., None], flow, rho=1.0), contrast=1.5, softness=4.0)
    np.testing.assert_allclose(second, again, atol=1e-5)
    assert (1 - second).sum() > (1 - first).sum()  # lines grow


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: fdog_iterative(image, flow, color_weight=0.5, softness=2.0))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"code": np.zeros((4, 5, 2))}, "code"),
        ({"flow": np.zeros((4, 6, 2))}, "flow"),
        ({"iterations": 0}, "iterations"),
        ({"iterations": 1.0}, "iterations"),
        ({"pre_blur": -1}, "pre_blur"),
        ({"sigma_c": -1}, "sigma_c"),
        ({"tau": 2}, "tau"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        fdog_iterative(**({"code": np.zeros((4, 5)), "flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter


@pytest.mark.parametrize("scale", ["full", "1/2"])
def test_code_values_that_nobody_else_holds_are_let_go_before_the_first_pass(scale, monkeypatch):
    _, flow = cases()["noise"]
    held = []

    def code():
        held.append(weakref.ref(made := np.full((*flow.shape[:2], 3), np.float32(9))))
        return made

    def response(*arguments):
        end = time.monotonic() + 5
        while held[0]() is not None and time.monotonic() < end:  # threads let go of what they reduced a little later
            time.sleep(0.001)
        assert held[0]() is None
        return original(*arguments)

    original = Detector.response
    monkeypatch.setattr(Detector, "response", response)
    passes = Passes.checked(**DEFAULTS | {"color_weight": 1.0, "working_scale": scale})
    lines, _ = passes.draw(code(), flow)
    assert lines.shape == flow.shape[:2]
