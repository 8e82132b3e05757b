import numpy as np
import pytest
from numba import njit

from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.matrix3 import mix, mix_second_row, rows
from flowabs_nodes.simd.memory import load, store

MATRIX = np.array([[0.5, 0.3, 0.2], [0.25, 0.7, 0.05], [-0.1, 0.2, 0.9]])


@njit
def _mixed(m, colors, out):
    r, g, b = load(colors, 0), load(colors, LANES), load(colors, 2 * LANES)
    x, y, z = mix(m, r, g, b)
    store(out, 0, x)
    store(out, LANES, y)
    store(out, 2 * LANES, z)
    store(out, 3 * LANES, mix_second_row(m, r, g, b))


def mixed(colors):
    """Return the results of mix and of mix_second_row for colours (3, 16), (4, 16)."""
    out = np.zeros((4, LANES), np.float32)
    _mixed(rows(MATRIX), colors.astype(np.float32).reshape(-1), out.reshape(-1))
    return out


def test_the_numbers_beside_the_diagonal_say_all():
    assert rows(MATRIX) == (0.3, 0.2, 0.25, 0.05, -0.1, 0.2)


def test_mix_is_the_product_with_the_matrix():
    colors = np.random.default_rng(0).uniform(0, 10, (3, LANES)).astype(np.float32)
    found = mixed(colors)
    np.testing.assert_allclose(found[:3], MATRIX @ colors, rtol=1e-6)
    np.testing.assert_array_equal(found[3], found[1])


@pytest.mark.parametrize("scale", [1e-30, 0.18, 1, 12345.678])
def test_a_neutral_colour_stays_neutral_to_the_last_bit(scale):
    gray = (scale * np.arange(LANES)).astype(np.float32)
    np.testing.assert_array_equal(mixed(np.stack([gray] * 3)), [gray] * 4)
