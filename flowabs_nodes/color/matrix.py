"""3x3 matrices whose rows sum to 1, in a form that keeps neutrals neutral to the last bit.

A row m0 r + m1 g + m2 b with m0 + m1 + m2 = 1 is r + m1 (g - r) + m2 (b - r): where r = g = b nothing is left to round.
Each row starts from its own channel: the first from r, the second from g, the third from b, usually its largest.

The products are made in float64 registers: saturated colours of wide gamuts (AP0's blue) cancel in Y, where L* is
steep.
"""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

f32, f64 = np.float32, np.float64
#: The two off-diagonal numbers of each row.
Rows = tuple[float, float, float, float, float, float]


def rows(matrix: npt.NDArray[np.float64]) -> Rows:
    """What :func:`mix` needs of a 3x3 matrix whose rows sum to 1."""
    (_, m01, m02), (m10, _, m12), (m20, m21, _) = matrix.tolist()
    return (m01, m02, m10, m12, m20, m21)


@numba.njit(error_model="numpy")
def mix(m: Rows, r: float, g: float, b: float) -> tuple[np.float32, np.float32, np.float32]:
    """The matrix times (r, g, b)."""
    r, g, b = f64(r), f64(g), f64(b)
    return (
        f32(r + (m[0] * (g - r) + m[1] * (b - r))),
        f32(g + (m[2] * (r - g) + m[3] * (b - g))),
        f32(b + (m[4] * (r - b) + m[5] * (g - b))),
    )


@numba.njit(error_model="numpy")
def not_finite(r: float, g: float, b: float) -> bool:
    """True where any of the three is NaN or Inf (x - x is 0 for all other numbers)."""
    return (r - r) + (g - g) + (b - b) != f32(0)
