import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import dog, etf, fdog, fdog_iterative, threshold, xdog, xdog_rho
from tests.filters.pictures import photo
from tests.naive import fdog as naive

GREY = photo().mean(-1)
FLOW = etf(GREY)


@pytest.mark.parametrize("p", [0, 0.5, 20, 100])
def test_d_is_the_picture_sharpened_p_times(p):
    _, sharpened = xdog(dog(GREY, 1.3, xdog_rho(p)), p)
    steps = naive.surround(1.3)
    expected = (1 + p) * naive.blur(GREY, 1.3, steps) - p * naive.blur(GREY, 1.6 * 1.3, steps)
    np.testing.assert_allclose(sharpened, expected, atol=1e-4 * (1 + p))


@pytest.mark.parametrize(("p", "epsilon", "phi"), [(20, 0, 0.01), (50, 128, 1), (10, 180, 0.005), (100, -30, 0.05)])
def test_lines_are_those_of_float64(p, epsilon, phi):
    response = fdog(GREY, FLOW, rho=xdog_rho(p))
    lines, sharpened = xdog(response, p, epsilon, phi)
    d = (1 + p) * response.astype(np.float64)
    np.testing.assert_allclose(sharpened, d, rtol=1e-6)
    np.testing.assert_allclose(lines, np.where(d >= epsilon, 1, 1 + np.tanh(phi * (d - epsilon))), atol=1e-6)
    assert 0 < (lines < 0.5).mean() < 0.9


def test_a_constant_picture_is_its_tone():
    for value in (40.0, 200.0):
        response = dog(np.full((9, 9), value), 1.0, xdog_rho(20))
        expected = 1 if value > 150 else 1 + np.tanh(0.01 * (value - 150))
        np.testing.assert_allclose(xdog(response, 20, 150, 0.01)[0], expected, atol=1e-4)


def test_a_steep_way_at_level_0_is_the_papers_threshold_at_tau_1():
    response = fdog(GREY, FLOW, rho=xdog_rho(20))
    hard, _ = xdog(response, 20, 0, 1000)
    np.testing.assert_array_equal(hard < 0.5, threshold(response, tau=1.0, softness=0) < 0.5)


def test_iterative_draws_in_this_form():
    form = {"form": "xdog", "p": 30, "epsilon": 90, "phi": 0.02}
    lines, response = fdog_iterative(GREY, FLOW, iterations=1, **form)
    once, sharpened = xdog(fdog(GREY, FLOW, rho=xdog_rho(30)), 30, 90, 0.02)
    np.testing.assert_array_equal(lines, once)
    np.testing.assert_array_equal(response, sharpened)
    again, _ = fdog_iterative(GREY, FLOW, iterations=2, **form)
    expected, _ = xdog(fdog(GREY * once, FLOW, rho=xdog_rho(30)), 30, 90, 0.02)
    np.testing.assert_allclose(again, expected, atol=1e-4)


@given(
    response=arrays(np.float32, (2, 3), elements=st.floats(-(2.0**120), 2.0**120, width=32)),
    p=st.floats(0, 10_000),
    epsilon=st.floats(-1e300, 1e300),
    phi=st.floats(0, 1e300),
)
def test_lines_are_from_0_to_1_and_all_is_finite(response, p, epsilon, phi):
    lines, sharpened = xdog(response, p, epsilon, phi)
    assert lines.dtype == sharpened.dtype == np.float32
    assert ((lines >= 0) & (lines <= 1)).all()
    assert np.isfinite(sharpened).all()


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"response": np.array([[np.nan]])}, "response"),
        ({"p": -1}, "p"),
        ({"p": None}, "p"),
        ({"epsilon": np.inf}, "epsilon"),
        ({"phi": -0.1}, "phi"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        xdog(**({"response": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter


def test_an_unknown_form_is_an_error():
    with pytest.raises(ArgumentError, match="form"):
        fdog_iterative(GREY, FLOW, form="xdg")
