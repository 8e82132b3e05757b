"""Cube root, log2 and exp2 of float32, of additions and multiplications only: the kernels around them vectorise.

The polynomials are minimax fits over the ranges said beside them. No table, no library call and no fastmath anywhere
in the colour kernels: the same bits on every machine.
"""

from __future__ import annotations

import numba
import numpy as np

f32 = np.float32
i32 = np.int32


@numba.njit(error_model="numpy")
def cube_root(x: np.float32) -> np.float32:
    """x^(1/3) of a normal x > 0, within 2 units in the last place; any other x gives some number."""
    # The bits of a float are nearly 2^23 (log2 x + 127), so a third of them gives 1/cbrt(x), here within 6 % ...
    y = i32(f32(1418608640.0) - f32(f32(x).view(i32)) * f32(1 / 3)).view(f32)
    # ... which p(x y^3), p(c) ~ c^(-1/3) on 0.667 .. 0.791, takes to 2.7e-5,
    c = (x * y) * (y * y)
    y *= f32(1.73084534) + c * (f32(-1.1907579) + c * f32(0.46727044))
    # and one step of Newton's for cbrt(x) = x y^2 to the rounding.
    d = x * y * y
    return d * (f32(1) + f32(2 / 3) * (f32(1) - d * y))


@numba.njit(error_model="numpy")
def log2(x: np.float32) -> np.float32:
    """log2 of a normal x > 0, within 1e-7 of max(1, |log2 x|); any other x gives some number."""
    # x = 2^e (1 + t), 2/3 <= 1 + t < 4/3, so that nothing cancels near x = 1.
    bits = f32(x).view(i32)
    e = (bits - i32(0x3F2AAAAB)) >> i32(23)
    t = i32(bits - (e << i32(23))).view(f32) - f32(1)
    p = f32(-0.22571322) + t * f32(0.21181467)  # log2(1 + t) / t, within 1e-8
    p = f32(-0.23604523) + t * (f32(0.19961862) + t * p)
    p = f32(-0.36083691) + t * (f32(0.28888352) + t * p)
    p = f32(-0.72134569) + t * (f32(0.48089115) + t * p)
    return f32(e) + t * (f32(1.44269508) + t * p)


@numba.njit(error_model="numpy")
def exp2(x: np.float32) -> np.float32:
    """2^x for x > -125, relatively within 1.1e-7; above 127.49 it stays at 2^127.49, so that nothing becomes Inf."""
    x = min(x, f32(127.49))
    n = i32(np.floor(x + f32(0.5)))
    t = x - f32(n)
    p = f32(0.00961842199) + t * (f32(0.00134000765) + t * f32(0.000153618236))  # 2^t on -1/2 .. 1/2, within 2e-9
    p = f32(0.693147207) + t * (f32(0.240226477) + t * (f32(0.0555032816) + t * p))
    return (f32(1) + t * p) * i32((n + i32(127)) << i32(23)).view(f32)
