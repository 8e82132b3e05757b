import math

import numpy as np
import pytest

from flowabs_nodes.filters import gaussian

SIGMAS = [0.3, 1.0, 2.0, 7.5]


def whole(half):
    """Both sides of a filter kernel, the centre once."""
    return np.concatenate([half[:0:-1], half])


@pytest.mark.parametrize(("sigma", "steps"), [(0, 0), (0.3, 1), (1, 3), (2, 6), (2.1, 7)])
def test_it_is_cut_at_three_sigma_rounded_up(sigma, steps):
    assert gaussian.radius(sigma) == steps
    assert gaussian.half(sigma).shape == (steps + 1,)


@pytest.mark.parametrize("sigma", SIGMAS)
@pytest.mark.parametrize("steps", [None, 40])
def test_both_sides_sum_to_one_and_fall_as_in_eq_7(sigma, steps):
    weights = gaussian.half(sigma, steps)
    assert whole(weights).sum() == pytest.approx(1, rel=1e-14)
    np.testing.assert_allclose(
        weights / weights[0], np.exp(-0.5 * (np.arange(weights.size) / sigma) ** 2), rtol=1e-12, atol=1e-30
    )


def test_known_weights():
    a, b, c, d = 1, np.exp(-0.5), np.exp(-2), np.exp(-4.5)
    np.testing.assert_allclose(gaussian.half(1.0), np.array([a, b, c, d]) / (a + 2 * (b + c + d)), rtol=1e-14)


@pytest.mark.parametrize("sigma", [0, 1e-200, 0.01])
def test_without_a_sigma_the_centre_has_all_the_weight(sigma):
    weights = gaussian.half(sigma, 3)
    np.testing.assert_array_equal(weights, [1, 0, 0, 0])


@pytest.mark.parametrize("sigma_c", SIGMAS)
def test_the_surround_is_wider_by_1_6_and_both_have_its_length(sigma_c):
    centre, surround = gaussian.centre_and_surround(sigma_c)
    assert centre.size == surround.size == int(np.ceil(4.8 * sigma_c)) + 1
    np.testing.assert_array_equal(surround, gaussian.half(1.6 * sigma_c))
    assert whole(centre).sum() == pytest.approx(1, rel=1e-14)
    assert centre[1] / centre[0] == pytest.approx(np.exp(-0.5 / sigma_c**2))


@pytest.mark.parametrize("rho", [0, 0.97, 1.0])
def test_a_difference_of_gaussians_keeps_1_minus_rho_of_a_constant(rho):
    taps = gaussian.difference(1.0, rho)
    centre, surround = gaussian.centre_and_surround(1.0)
    np.testing.assert_allclose(taps, centre - rho * surround, rtol=1e-15)
    assert whole(taps).sum() == pytest.approx(1 - rho, abs=1e-14)


@pytest.mark.parametrize("step", [2, 3])
def test_some_weights_alone_sum_to_one_and_keep_the_variance(step):
    every_one = gaussian.half(4.0)
    some = gaussian.every(step, every_one)
    kept = np.arange(every_one.size) % step == 0
    assert (some[kept] > 0).all()
    assert not some[~kept].any()
    assert math.isclose(2 * some.sum() - some[0], 1)
    squares = np.arange(every_one.size) ** 2
    assert math.isclose((some * squares).sum(), (every_one * squares).sum())
    np.testing.assert_allclose(some[kept], step * every_one[kept], rtol=0.06)
    assert gaussian.every(1, every_one) is every_one


def test_a_difference_at_some_offsets_keeps_what_it_makes_of_a_constant_and_of_a_parabola():
    for rho in (0.9, 1.0):
        taps, some = gaussian.difference(2.0, rho), gaussian.difference(2.0, rho, step=2)
        assert not some[1::2].any()
        assert whole(some).sum() == pytest.approx(1 - rho, abs=1e-14)
        squares = np.arange(taps.size) ** 2
        assert math.isclose((some * squares).sum(), (taps * squares).sum())


def test_a_weight_that_is_alone_has_it_all():
    np.testing.assert_array_equal(gaussian.every(3, gaussian.half(0.01)), [1, 0])
