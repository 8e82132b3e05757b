"""The operations that AVX-512 has instructions for against NumPy, on either path."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.simd import avx512
from flowabs_nodes.simd.lanes import LANES
from tests.simd.test_lanes import M, N, X, Y, kernel


def test_rough_inverse_root() -> None:
    """Its bound, over all of float32."""
    inverse_root = kernel(lambda x, _: avx512.approximate_rsqrt(x))
    for x in np.logspace(-37, 38, 320).reshape(-1, LANES).astype(np.float32):
        np.testing.assert_allclose(inverse_root(x, x), x.astype(np.float64) ** -0.5, rtol=2.0**-13)


def test_look_up_in_a_table_of_sixteen() -> None:
    np.testing.assert_array_equal(kernel(lambda table, i: avx512.table_lookup(table, i))(M, N), M[N & 15])


def test_fraction_and_scaling_by_a_power_of_two() -> None:
    np.testing.assert_array_equal(kernel(lambda x, _: avx512.fraction(x))(X, X), X - np.floor(X))
    scaled = kernel(lambda x, y: avx512.scale_by_exp2_floor(x, y))(X, Y)
    np.testing.assert_array_equal(scaled, X * np.exp2(np.floor(Y)))
