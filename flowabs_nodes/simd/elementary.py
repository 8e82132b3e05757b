"""Cube root, log2 and exp2 of sixteen float32, of additions and multiplications only.

The polynomials are minimax fits over the ranges said beside them.
"""

from __future__ import annotations

from typing import Any

from flowabs_nodes.simd.lanes import bits_of, floor, from_bits, inlined, minimum, to_floats, to_ints


@inlined
def cube_root(x: Any) -> Any:
    """x^(1/3) of a normal x > 0, within 2 units in the last place; any other x gives some number."""
    # The bits of a float are nearly 2^23 (log2 x + 127), so a third of them gives 1/cbrt(x), here within 6 % ...
    y = from_bits(to_ints(1418608640.0 - to_floats(bits_of(x)) * (1 / 3)))
    # ... which p(x y^3), p(c) ~ c^(-1/3) on 0.667 .. 0.791, takes to 2.7e-5,
    c = (x * y) * (y * y)
    y = y * (1.73084534 + c * (-1.1907579 + c * 0.46727044))
    # and one step of Newton's for cbrt(x) = x y^2 to the rounding.
    d = x * y * y
    return d * (1.0 + (2 / 3) * (1.0 - d * y))


@inlined
def log2(x: Any) -> Any:
    """log2 of a normal x > 0, within 1e-7 of max(1, |log2 x|); any other x gives some number."""
    # x = 2^e (1 + t), 2/3 <= 1 + t < 4/3, so that nothing cancels near x = 1.
    bits = bits_of(x)
    e = (bits - 0x3F2AAAAB) >> 23
    t = from_bits(bits - (e << 23)) - 1.0
    p = -0.22571322 + t * 0.21181467  # log2(1 + t) / t, within 1e-8
    p = -0.23604523 + t * (0.19961862 + t * p)
    p = -0.36083691 + t * (0.28888352 + t * p)
    p = -0.72134569 + t * (0.48089115 + t * p)
    return to_floats(e) + t * (1.44269508 + t * p)


@inlined
def exp2(x: Any) -> Any:
    """2^x for x > -125, relatively within 1.1e-7; above 127.49 it stays at 2^127.49, so that nothing becomes Inf."""
    x = minimum(x, 127.49)
    whole = floor(x + 0.5)
    t = x - whole
    p = 0.00961842199 + t * (0.00134000765 + t * 0.000153618236)  # 2^t on -1/2 .. 1/2, within 2e-9
    p = 0.693147207 + t * (0.240226477 + t * (0.0555032816 + t * p))
    return (1.0 + t * p) * from_bits((to_ints(whole) + 127) << 23)
