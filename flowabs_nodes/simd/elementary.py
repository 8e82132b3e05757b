"""Cube root, logarithm, powers of 2 and error function of sixteen float32 at a time.

The polynomials are minimax fits over the ranges in the comments beside them. There are three powers of 2 because each
digit costs time: :func:`exp2` for colours, :func:`exp2_of_negative` for the strength of lines, and :func:`exp2_weight`
for the weights of weighted means, where errors average out.
"""

from __future__ import annotations

from flowabs_nodes.simd.avx512 import fraction, scale_by_exp2_floor
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import (
    Floats,
    absolute,
    bits_of,
    floor,
    from_bits,
    maximum,
    minimum,
    rint,
    select,
    to_floats,
    to_ints,
)

#: The logarithm of e to base 2: e^x = 2^(LOG2_E x).
LOG2_E = 1.4426950408889634


@inlined
def cube_root(x: Floats) -> Floats:
    """Return x^(1/3) of a normal x > 0, within 2 units in the last place.

    Of Inf and NaN it is not finite; for any other x it is undefined.
    """
    # The bits of a float are nearly 2^23 (log2 x + 127), so a third of them gives 1/cbrt(x), here within 6 % ...
    y = from_bits(to_ints(1418608640.0 - to_floats(bits_of(x)) * (1 / 3)))
    # ... which p(x y^3), p(c) ~ c^(-1/3) on 0.667 .. 0.791, takes to 2.7e-5,
    c = (x * y) * (y * y)
    y = y * (1.73084534 + c * (-1.1907579 + c * 0.46727044))
    # and one step of Newton's method for cbrt(x) = x y^2 to the rounding.
    d = x * y * y
    return d * (1.0 + (2 / 3) * (1.0 - d * y))


@inlined
def log2(x: Floats) -> Floats:
    """Return log2 x of a normal x > 0, within 1e-7 max(1, |log2 x|); for any other x the result is undefined."""
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
def exp2(x: Floats) -> Floats:
    """Return 2^x for x > -125, with a relative error below 1.1e-7. Above 127.49 it is 2^127.49, never Inf."""
    x = minimum(x, 127.49)
    whole = floor(x + 0.5)
    t = x - whole
    p = 0.00961842199 + t * (0.00134000765 + t * 0.000153618236)  # 2^t on -1/2 .. 1/2, within 2e-9
    p = 0.693147207 + t * (0.240226477 + t * (0.0555032816 + t * p))
    return (1.0 + t * p) * from_bits((to_ints(whole) + 127) << 23)


@inlined
def exp2_of_negative(x: Floats) -> Floats:
    """Return 2^x for x <= 0, with a relative error below 3e-7. Below -100 it is 2^-100, which counts for nothing."""
    x = maximum(x, -100.0)
    whole = rint(x)
    t = x - whole
    p = t * 0.0013276474 + 0.009675542  # 2^t on -1/2 .. 1/2
    p = p * t + 0.055507133
    p = p * t + 0.2402212
    p = p * t + 0.69314697
    p = p * t + 1.0
    return p * from_bits((to_ints(whole) + 127) << 23)


@inlined
def exp2_weight(x: Floats) -> Floats:
    """Return 2^x for x <= 0, with a relative error below 4e-6. Below -100 it is 2^-100, which counts for nothing."""
    x = maximum(x, -100.0)  # sums with subnormal numbers, below 2^-126, would be slow
    t = fraction(x)
    p = t * 0.01353417 + 0.05201146  # 2^t on 0 .. 1
    p = p * t + 0.24144276
    p = p * t + 0.69300383
    p = p * t + 1.0000026
    return scale_by_exp2_floor(p, x)


@inlined
def erf(x: Floats) -> Floats:
    """Return the error function of x within 5e-7 (Abramowitz and Stegun, 7.1.26)."""
    size = minimum(absolute(x), 8.0)  # beyond, it is 1
    t = 1.0 / (1.0 + 0.3275911 * size)
    p = 1.421413741 + t * (-1.453152027 + t * 1.061405429)
    p = t * (0.254829592 + t * (-0.284496736 + t * p))
    value = 1.0 - p * exp2_of_negative(size * size * -LOG2_E)
    return select(x < 0.0, -value, value)
