"""The kernels' own functions against float64, over every binade."""

import numpy as np
import pytest
from numba import njit
from scipy import special

from flowabs_nodes.simd import elementary
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import load, store


def _each(function, values):
    """A function of sixteen floats of every value."""

    @njit(error_model="numpy", fastmath={"contract"})
    def loop(values, result):
        for i in range(0, values.size, LANES):
            store(result, i, function(load(values, i)))

    padded = np.append(values, np.ones(-values.size % LANES, np.float32))
    result = np.empty_like(padded)
    loop(padded, result)
    return result[: values.size]


NORMAL = np.arange(0x00800000, 0x7F800000, 9973, dtype=np.int32).view(np.float32)  # every exponent


def test_cube_root_is_within_two_units_in_the_last_place():
    exact = np.cbrt(NORMAL.astype(np.float64))
    error = np.abs(_each(elementary.cube_root, NORMAL) - exact)
    assert (error / np.spacing(exact.astype(np.float32))).max() < 2


def test_log2():
    exact = np.log2(NORMAL.astype(np.float64))
    error = np.abs(_each(elementary.log2, NORMAL) - exact)
    assert (error / np.maximum(1, np.abs(exact))).max() < 1e-7
    near_one = np.float32(1) + np.linspace(-1e-3, 1e-3, 1001).astype(np.float32)
    exact = np.log2(near_one.astype(np.float64))
    np.testing.assert_allclose(_each(elementary.log2, near_one), exact, rtol=3e-7, atol=1e-12)


def test_exp2():
    x = np.linspace(-125, 127.4, 50_001).astype(np.float32)
    np.testing.assert_allclose(_each(elementary.exp2, x), np.exp2(x.astype(np.float64)), rtol=1.1e-7)
    assert _each(elementary.exp2, np.array([0, 1, 10], np.float32)).tolist() == [1, 2, 1024]
    assert np.isfinite(_each(elementary.exp2, np.array([127.6, 1e6, 3e38], np.float32))).all()


SMALL = -np.concatenate([np.linspace(0, 100, 200_001), np.geomspace(1e-30, 100, 10_001)]).astype(np.float32)


@pytest.mark.parametrize(("power", "error"), [(elementary.exp2_of_negative, 3e-7), (elementary.exp2_weight, 4e-6)])
def test_exp2_of_numbers_below_zero(power, error):
    np.testing.assert_allclose(_each(power, SMALL), 2.0 ** SMALL.astype(np.float64), rtol=error)
    powers = _each(power, np.array([-100.5, -1e5, -1e38, -np.inf], np.float32))
    assert ((powers >= 0) & (powers <= 1e-30)).all()  # too small to count


def test_erf():
    x = np.concatenate([np.linspace(-9, 9, 100_001), [0, 1e-30, -1e-30, 1e6, -1e6, 3e38, np.inf, -np.inf]])
    x = x.astype(np.float32)
    np.testing.assert_allclose(_each(elementary.erf, x), special.erf(x.astype(np.float64)), rtol=0, atol=5e-7)
