import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import threshold
from tests.naive import fdog as naive

RESPONSE = np.linspace(-20, 20, 4001, dtype=np.float32).reshape(1, -1)


@pytest.mark.parametrize("tau", [0, 0.01, 0.2, 0.5, 0.7, 0.99, 1])
def test_is_eq_9(tau):
    np.testing.assert_array_equal(threshold(RESPONSE, tau), naive.threshold(RESPONSE, tau))


def test_tau_0_is_paper_alone_and_tau_1_inks_all_below_0():
    assert threshold(RESPONSE, 0).all()
    assert threshold(RESPONSE, 0, softness=5).all()
    np.testing.assert_array_equal(threshold(RESPONSE, 1) == 0, RESPONSE < 0)


@pytest.mark.parametrize(("contrast", "softness"), [(None, 4), (1.5, 4), (0, 2), (3, 0.1), (2, 0), (0, 0)])
def test_contrast_and_softness(contrast, softness):
    expected = naive.threshold(RESPONSE, 0.5, contrast, softness)
    np.testing.assert_allclose(threshold(RESPONSE, 0.5, contrast, softness), expected, atol=1e-6)


def test_the_default_contrast_is_that_of_tau():
    c = -math.atanh(0.3 - 1)
    np.testing.assert_array_equal(threshold(RESPONSE, 0.3, softness=3), threshold(RESPONSE, 0.9, c, 3))


def test_the_step_ends_where_the_hard_one_is():
    at = np.array([[-5.51, -5.5, -3.5, -1.5, -1.49]], np.float32)  # -c - s = -5.5, -c = -1.5
    np.testing.assert_allclose(threshold(at, contrast=1.5, softness=4), [[0, 0, 0.5, 1, 1]], atol=1e-6)
    np.testing.assert_array_equal(threshold(at, contrast=1.5), [[0, 0, 0, 1, 1]])


@given(
    response=arrays(np.float32, (2, 3), elements=st.floats(-(2.0**100), 2.0**100, width=32)),
    tau=st.floats(0, 1),
    contrast=st.none() | st.floats(0, 1e300),
    softness=st.floats(0, 1e300),
)
def test_lines_are_from_0_to_1_and_paper_where_the_response_is_not_negative(response, tau, contrast, softness):
    lines = threshold(response, tau, contrast, softness)
    assert lines.dtype == np.float32
    assert ((lines >= 0) & (lines <= 1)).all()
    assert (lines[response >= 0] == 1).all()


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"response": np.zeros((2, 2, 3))}, "response"),
        ({"response": np.array([[np.nan]])}, "response"),
        ({"tau": 1.1}, "tau"),
        ({"tau": None}, "tau"),
        ({"contrast": -1}, "contrast"),
        ({"contrast": math.inf}, "contrast"),
        ({"softness": -1}, "softness"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        threshold(**({"response": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter
