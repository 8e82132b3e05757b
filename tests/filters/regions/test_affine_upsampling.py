import numpy as np
import pytest

from flowabs_nodes.filters import blur
from flowabs_nodes.filters.regions.affine_upsampling import upsampled
from flowabs_nodes.sampling.resolution import reduced
from tests.naive import resolution as naive

SHAPES = [(1, 1), (1, 23), (23, 1), (17, 40), (36, 51)]
FACTORS = [2, 4]


def noise(shape, seed=0):
    return np.random.default_rng(seed).uniform(0, 255, shape).astype(np.float32)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_equals_the_equations_in_float64(shape, factor):
    codes = noise((*shape, 3))
    small = reduced(codes, factor)
    smoothed = blur(small, 0.7)
    found = upsampled(codes, small, smoothed, factor, None, None)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, naive.upsampled(codes, small, smoothed, factor), rtol=0, atol=1e-3)


@pytest.mark.parametrize("factor", FACTORS)
def test_reduced_pixels_count_by_their_coverage(factor):
    codes, alpha = noise((30, 44, 3)), noise((30, 44), 1) / 255
    alpha[:16, :20] = 0
    small, covered = reduced(codes, factor, alpha), reduced(alpha, factor)
    smoothed = blur(small, 0.7)
    found = upsampled(codes, small, smoothed, factor, alpha, covered)
    expected = naive.upsampled(codes, small, smoothed, factor, covered)
    np.testing.assert_allclose(found[alpha > 0], expected[alpha > 0], rtol=0, atol=1e-3)
    np.testing.assert_array_equal(found[alpha == 0], codes[alpha == 0])


@pytest.mark.parametrize("factor", FACTORS)
def test_a_constant_picture_stays_exactly_that(factor):
    codes = np.full((19, 23, 3), np.float32(0.1))
    small = reduced(codes, factor)
    np.testing.assert_array_equal(upsampled(codes, small, small, factor, None, None), codes)


def test_an_edge_that_was_left_is_as_sharp_as_it_was():
    codes = np.full((40, 64, 3), 30, np.float32)
    codes[:, 31:] = 200  # inside a block
    small = reduced(codes, 2)
    np.testing.assert_allclose(upsampled(codes, small, small, 2, None, None), codes, atol=0.5)


def test_detail_that_was_smoothed_away_stays_away():
    codes = 100 + noise((40, 64, 3)) / 25  # grain of 10 code values
    small = reduced(codes, 2)
    flat = upsampled(codes, small, np.full_like(small, 105), 2, None, None)
    np.testing.assert_allclose(flat, 105, atol=1e-3)
