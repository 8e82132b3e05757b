import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import blur, halo, quantize
from flowabs_nodes.simd.bands import limited
from tests.naive import quantize as naive


@pytest.mark.parametrize("softness", [0, 0.1, 0.5, 1])
@pytest.mark.parametrize("levels", [1, 4, 7, 8, 10])
def test_equals_the_definition(levels, softness):
    lstar = np.linspace(-20, 300, 3201, dtype=np.float32)
    expected = [naive.quantize(float(value), levels, softness) for value in lstar]
    np.testing.assert_allclose(quantize(lstar[None], levels, softness)[0], expected, atol=1e-4)


@pytest.mark.parametrize("softness", [0, 0.1, 0.5, 1])
@pytest.mark.parametrize("phase", [0.1, 0.5, 0.8, 1])
def test_a_phase_moves_the_steps(phase, softness):
    lstar = np.linspace(-20, 300, 3201, dtype=np.float32) + np.float32(0.013)  # not at a hard step
    expected = [naive.quantize(float(value), 8, softness, phase) for value in lstar]
    np.testing.assert_allclose(quantize(lstar[None], 8, softness, phase)[0], expected, atol=1e-4)
    moved = quantize(lstar[None] + np.float32(12.5 * phase), 8, softness, phase)[0] - 12.5 * phase
    np.testing.assert_allclose(moved[lstar > 13], quantize(lstar[None], 8, softness)[0][lstar > 13], atol=1e-3)


def test_a_phase_of_one_is_none():
    lstar = np.linspace(0, 130, 1301)[None]
    np.testing.assert_allclose(quantize(lstar, 8, phase=1.0), quantize(lstar, 8), atol=1e-5)


def test_the_bin_that_a_phase_cuts_off_at_black_has_the_middle_of_what_is_left():
    np.testing.assert_allclose(quantize([[0, 4.9, 5.1]], 8, phase=0.4), [[2.5, 2.5, 11.25]], rtol=1e-6)


@pytest.mark.parametrize("softness", [0, 0.7])
@pytest.mark.parametrize("by_gradient", [0.3, 1.0])
@pytest.mark.parametrize("phase", [0, 0.6])
def test_by_the_gradient_equals_the_definition(softness, by_gradient, phase):
    y, x = np.mgrid[:37, :53]
    lstar = np.float32(50 + 30 * np.tanh((x + 0.3 * y - 30) / 3) + 0.2 * y)  # an edge of every rise, and a slow ramp
    rises = naive.rises(lstar, 1.5)
    expected = [
        naive.by_gradient(float(value), steep, 8, softness, phase, by_gradient, 4.0)
        for value, steep in zip(lstar.ravel(), rises.ravel(), strict=True)
    ]
    found = quantize(lstar, 8, softness, phase, by_gradient, 1.5, 4.0)
    np.testing.assert_allclose(found.ravel(), expected, atol=2e-3)


@pytest.mark.parametrize("slope", [0.02, 0.05, 0.1, 0.3])
@pytest.mark.parametrize("levels", [4, 8, 10, 16])
def test_a_clear_sky_keeps_its_ramp(slope, levels):
    """With 12-bit noise, the slope is .5 to 1.5 of the plate's on 99 % of it; without the gradient it is 0 to 2."""
    ramp = 30 + slope * np.arange(60 / slope) + np.zeros((30, 1))
    noisy = (ramp + np.random.default_rng(1).normal(0, 100 / 4096, ramp.shape)).astype(np.float32)

    def slopes(picture):
        return np.diff(blur(picture, 4.0), axis=1)[:, 12:-12]

    def share_that_is_kept(by_gradient):
        ratio = slopes(quantize(noisy, levels, 0.7, by_gradient=by_gradient)) / slopes(noisy)
        return ((ratio > 0.5) & (ratio < 1.5)).mean()

    assert share_that_is_kept(1.0) > 0.99
    assert share_that_is_kept(0.0) < 0.75


def test_a_soft_edge_is_flattened_and_a_slow_ramp_is_not():
    """Of an edge that rises by 4 L* a pixel most becomes the middle of a bin; of one that rises by .2 a small part."""

    def share_in_the_middle_of_a_bin(slope):
        lstar = np.repeat((20 + slope * np.arange(60 / slope))[None], 9, 0)
        flat = quantize(lstar, 5, by_gradient=1.0)
        return (np.abs(flat % 20 - 10) < 2).mean()

    assert share_in_the_middle_of_a_bin(4.0) > 0.6
    assert share_in_the_middle_of_a_bin(0.2) < 0.4


def test_a_sharp_edge_keeps_its_antialiasing():
    """A pixel that the edge covers by halves stays between its sides, where a hard step would take one of them."""
    lstar = np.repeat(np.float32([[46] * 20 + [50] + [54] * 20]) * 1.0, 9, 0)
    assert 44 < quantize(lstar, 10, by_gradient=1.0)[4, 20] < 56
    assert quantize(lstar, 10)[4, 20] in (45, 55)
    steep = np.repeat(np.float32([[20] * 20 + [50] + [80] * 20]), 9, 0)
    assert np.abs(quantize(steep, 10, by_gradient=1.0) - steep).max() < 5.1


def test_by_the_gradient_any_number_of_threads_and_a_crop_give_the_same_bits():
    lstar = np.random.default_rng(3).uniform(0, 100, (150, 90)).astype(np.float32)
    given = (8, 0.5, 0.3, 1.0, 1.6)
    with limited(1):
        expected = quantize(lstar, *given)
    with limited(5):
        np.testing.assert_array_equal(quantize(lstar, *given), expected)
    reach = halo.quantize(1.0, 1.6)
    cut = quantize(lstar[40 - reach : 80 + reach, 30 - reach : 61 + reach], *given)
    np.testing.assert_array_equal(cut[reach:-reach, reach:-reach], expected[40:80, 30:61])


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
        ({"phase": -0.1}, "phase"),
        ({"by_gradient": 1.1}, "by_gradient"),
        ({"gradient_length": 0}, "gradient_length"),
        ({"hard_gradient": 0}, "hard_gradient"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        quantize(**({"lstar": np.zeros((2, 2))} | arguments))
    assert error.value.parameter == parameter
