import numpy as np
import pytest

from flowabs_nodes.simd import bands
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels


@kernel
def _double(first, last, numbers, result):
    for block in range(first, last):
        i = first_pixel(block, numbers.size)
        store(result, i, load(numbers, i) * 2.0)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (1, 16), (17, 1), (61, 97), (200, 301)])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_every_pixel_of_any_picture_is_reached(shape, count):
    picture = np.random.default_rng(0).random(shape, np.float32)
    run, result = as_run(picture), empty_run(picture.size)
    with bands.limited(count):
        over_pixels(_double, run.size, run, result)
    np.testing.assert_array_equal(as_picture(result, *shape), 2 * picture)


def test_a_run_is_the_picture_s_own_memory_but_for_tiny_ones():
    picture = np.zeros((4, 5, 3), np.float32)
    assert np.shares_memory(as_run(picture, 3), picture)
    assert as_run(picture[:2], 3).size == 48
    assert not np.shares_memory(as_run(picture[:2], 3), picture)
