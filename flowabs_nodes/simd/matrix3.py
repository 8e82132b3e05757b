"""Products with 3x3 matrices whose rows sum to 1, in a form that keeps neutral colours neutral to the last bit.

A row m0 r + m1 g + m2 b with m0 + m1 + m2 = 1 equals r + m1 (g - r) + m2 (b - r). Where r = g = b, both differences are
0 and nothing is rounded. The first row starts from r like this, the second from g and the third from b: the channel
that usually has the largest weight in the row.

The products are computed in float64: for saturated colours of wide gamuts (AP0's blue) the terms nearly cancel in Y,
where L* is steep.
"""

from __future__ import annotations

from flowabs_nodes.array_types import Float64
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import Floats, from_doubles, to_doubles

#: The six off-diagonal numbers of a 3x3 matrix, row by row.
Rows = tuple[float, float, float, float, float, float]


def rows(matrix: Float64) -> Rows:
    """Return the off-diagonal numbers of a 3x3 ``matrix`` whose rows sum to 1."""
    (_, m01, m02), (m10, _, m12), (m20, m21, _) = matrix.tolist()
    return (m01, m02, m10, m12, m20, m21)


@inlined
def mix(m: Rows, r: Floats, g: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the matrix with the off-diagonal numbers ``m`` times (r, g, b), in each lane."""
    r, g, b = to_doubles(r), to_doubles(g), to_doubles(b)
    return (
        from_doubles(r + (m[0] * (g - r) + m[1] * (b - r))),
        from_doubles(g + (m[2] * (r - g) + m[3] * (b - g))),
        from_doubles(b + (m[4] * (r - b) + m[5] * (g - b))),
    )


@inlined
def mix_second_row(m: Rows, r: Floats, g: Floats, b: Floats) -> Floats:
    """Return the second of the three results of :func:`mix` (Y, of a matrix from RGB to XYZ)."""
    r, g, b = to_doubles(r), to_doubles(g), to_doubles(b)
    return from_doubles(g + (m[2] * (r - g) + m[3] * (b - g)))
