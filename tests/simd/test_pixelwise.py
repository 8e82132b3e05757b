import numpy as np
import pytest

from flowabs_nodes.simd import bands
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import first_of, new_run, over_pixels, picture_of, run_of


@kernel
def _double(first, last, numbers, result):
    for block in range(first, last):
        i = first_of(block, numbers.size)
        store(result, i, load(numbers, i) * 2.0)


@pytest.mark.parametrize("shape", [(1, 1), (3, 5), (1, 16), (17, 1), (61, 97), (200, 301)])
@pytest.mark.parametrize("count", [1, 2, 5])
def test_every_pixel_of_any_picture_is_reached(shape, count):
    picture = np.random.default_rng(0).random(shape, np.float32)
    run, result = run_of(picture), new_run(picture.size)
    with bands.limited(count):
        over_pixels(_double, run.size, run, result)
    np.testing.assert_array_equal(picture_of(result, *shape), 2 * picture)


def test_a_run_is_the_picture_s_own_memory_but_for_tiny_ones():
    picture = np.zeros((4, 5, 3), np.float32)
    assert np.shares_memory(run_of(picture, 3), picture)
    assert run_of(picture[:2], 3).size == 48
    assert not np.shares_memory(run_of(picture[:2], 3), picture)
