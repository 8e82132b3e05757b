import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import quantize
from tests.naive import quantize as naive


@pytest.mark.parametrize("softness", [0, 0.1, 0.5, 1])
@pytest.mark.parametrize("levels", [1, 4, 7, 8, 10])
def test_equals_the_definition(levels, softness):
    lstar = np.linspace(-20, 300, 3201, dtype=np.float32)
    expected = [naive.quantize(float(value), levels, softness) for value in lstar]
    np.testing.assert_allclose(quantize(lstar[None], levels, softness)[0], expected, atol=1e-4)


def test_bins():
    lstar = np.array([[-50, 0, 12.5, 12.6, 99, 100, 101, 112.5]])  # 8 bins of 12.5
    bins = np.array([[1, 1, 1, 2, 8, 8, 9, 9]])
    np.testing.assert_allclose(quantize(lstar), (bins - 0.5) * 12.5)


@given(lstar=st.floats(0, 1e6, width=32), levels=st.integers(1, 1000), softness=st.floats(0.01, 1))
def test_a_soft_step_stays_within_half_a_bin(lstar, levels, softness):
    assert abs(float(quantize([[lstar]], levels, softness)[0, 0]) - lstar) <= 50.1 / levels + 1e-5 * abs(lstar)


@given(lstar=st.floats(-(2.0**99), 0, width=32), levels=st.integers(1, 1000), softness=st.floats(0, 1))
def test_what_is_darker_than_black_stays_in_the_first_bin(lstar, levels, softness):
    assert 0 <= float(quantize([[lstar]], levels, softness)[0, 0]) <= 50.1 / levels


def test_lightness_whose_bins_leave_float32_is_refused():
    with pytest.raises(ArgumentError, match=r"lstar: .* the first 3e\+38 at x 2, y 1"):
        quantize([[1, 2, 3], [4, 5, 3e38]], levels=1000)


@given(
    pair=st.lists(st.floats(-100, 1000, width=32), min_size=2, max_size=2),
    levels=st.integers(1, 50),
    softness=st.floats(0, 1),
)
def test_brighter_stays_brighter(pair, levels, softness):
    dark, bright = quantize([sorted(pair)], levels, softness)[0]
    assert dark <= bright + 1e-4


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"lstar": np.zeros((2, 2, 3))}, "lstar"),
        ({"lstar": np.array([[np.inf]])}, "lstar"),
        ({"levels": 0}, "levels"),
        ({"levels": 8.0}, "levels"),
        ({"softness": 1.1}, "softness"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        quantize(**({"lstar": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter
