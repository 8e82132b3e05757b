import numpy as np
import pytest

from flowabs_nodes.sampling.resolution import enlarged, reduced, reduced_planes
from flowabs_nodes.simd import bands
from tests.naive import resolution as naive

SHAPES = [(1, 1), (1, 7), (9, 1), (2, 4), (13, 30), (34, 71), (40, 64)]
FACTORS = [2, 4]


def noise(shape, seed=0):
    return np.random.default_rng(seed).uniform(0, 255, shape).astype(np.float32)


def small_size(shape, factor):
    return tuple(-(-size // factor) for size in shape)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_reduced_are_the_means_of_blocks(shape, factor):
    for picture in (noise(shape), noise((*shape, 3))):
        np.testing.assert_allclose(reduced(picture, factor), naive.reduced(picture, factor), rtol=1e-6)


@pytest.mark.parametrize("factor", FACTORS)
def test_weights_say_what_pixels_count(factor):
    picture, weights = noise((23, 34, 3)), noise((23, 34), 1) / 255
    weights[:12, :16] = 0
    small = reduced(picture, factor, weights)
    np.testing.assert_allclose(small, naive.reduced(picture, factor, weights), rtol=1e-5)
    assert (small[:3, :4] == 0).all()


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_enlarged_is_the_cubic_at_every_pixel(shape, factor):
    planes = noise((2, *small_size(shape, factor)))
    large = enlarged(planes, factor, *shape)
    assert large.dtype == np.float32
    for plane, result in zip(planes, large, strict=True):
        np.testing.assert_allclose(result, naive.enlarged(plane, factor, *shape), rtol=1e-5, atol=1e-3)


@pytest.mark.parametrize("factor", [1, *FACTORS])
def test_some_rows_of_the_enlarged_are_those_of_all(factor):
    planes = noise((2, *small_size((23, 34), factor)))
    whole = enlarged(planes, factor, 23, 34)
    for first, last in ((0, 23), (0, 1), (5, 18), (22, 23)):
        np.testing.assert_array_equal(enlarged(planes, factor, 23, 34, first, last), whole[:, first:last])


@pytest.mark.parametrize("factor", FACTORS)
def test_reduced_planes_are_those_of_each(factor):
    planes = noise((3, 23, 34))
    for small, plane in zip(reduced_planes(planes, factor), planes, strict=True):
        np.testing.assert_array_equal(small, reduced(plane, factor))
    assert reduced_planes(planes, 1) is planes


def test_a_factor_of_1_changes_nothing():
    picture = noise((5, 6))
    assert reduced(picture, 1) is picture
    np.testing.assert_array_equal(enlarged(picture[None], 1, 5, 6)[0], picture)


@pytest.mark.parametrize("factor", FACTORS)
def test_a_constant_picture_stays_exactly_that(factor):
    picture = np.full((19, 23), np.float32(0.1))
    small = reduced(picture, factor)
    assert (small == picture[0, 0]).all()
    assert (enlarged(small[None], factor, 19, 23) == picture[0, 0]).all()


@pytest.mark.parametrize("factor", FACTORS)
def test_a_ramp_comes_back_inside(factor):
    y, x = np.mgrid[:48, :64].astype(np.float32)
    ramp = 3 * x - 2 * y
    back = enlarged(reduced(ramp, factor)[None], factor, 48, 64)[0]
    inside = np.s_[3 * factor : -3 * factor, 3 * factor : -3 * factor]
    np.testing.assert_allclose(back[inside], ramp[inside], atol=1e-3)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("axis", [0, 1])
def test_flipped_pictures_give_flipped_results(factor, axis):
    picture = noise((24, 40))  # whole blocks
    back = enlarged(reduced(picture, factor)[None], factor, 24, 40)[0]
    flipped = np.ascontiguousarray(np.flip(picture, axis))
    flipped_back = enlarged(reduced(flipped, factor)[None], factor, 24, 40)[0]
    np.testing.assert_allclose(flipped_back, np.flip(back, axis), atol=1e-4)


@pytest.mark.parametrize("factor", FACTORS)
def test_a_picture_moved_by_a_block_gives_the_same_bits_moved(factor):
    picture = noise((64, 80))
    whole = enlarged(reduced(picture, factor)[None], factor, 64, 80)[0]
    part = np.ascontiguousarray(picture[factor:, 2 * factor :])
    moved = enlarged(reduced(part, factor)[None], factor, *part.shape)[0]
    rim = 3 * factor
    np.testing.assert_array_equal(moved[rim:-rim, rim:-rim], whole[factor + rim : -rim, 2 * factor + rim : -rim])


def test_any_number_of_threads_gives_the_same_bits():
    picture = noise((130, 70))
    results = []
    for threads in (1, 2, 3):
        with bands.limited(threads):
            results.append(enlarged(reduced(picture, 2)[None], 2, 130, 70))
    for result in results[1:]:
        np.testing.assert_array_equal(result, results[0])
