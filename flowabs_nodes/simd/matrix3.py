"""3x3 matrices whose rows sum to 1, in a form that keeps neutrals neutral to the last bit.

A row m0 r + m1 g + m2 b with m0 + m1 + m2 = 1 is r + m1 (g - r) + m2 (b - r): where r = g = b nothing is left to round.
Each row starts from its own channel: the first from r, the second from g, the third from b, usually its largest.

The products are made in float64 registers: saturated colours of wide gamuts (AP0's blue) cancel in Y, where L* is
steep.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import from_doubles, to_doubles

#: The two off-diagonal numbers of each row.
Rows = tuple[float, float, float, float, float, float]


def rows(matrix: npt.NDArray[np.float64]) -> Rows:
    """What :func:`mix` needs of a 3x3 matrix whose rows sum to 1."""
    (_, m01, m02), (m10, _, m12), (m20, m21, _) = matrix.tolist()
    return (m01, m02, m10, m12, m20, m21)


@inlined
def mix(m: Rows, r: Any, g: Any, b: Any) -> Any:
    """The matrix times (r, g, b)."""
    r, g, b = to_doubles(r), to_doubles(g), to_doubles(b)
    return (
        from_doubles(r + (m[0] * (g - r) + m[1] * (b - r))),
        from_doubles(g + (m[2] * (r - g) + m[3] * (b - g))),
        from_doubles(b + (m[4] * (r - b) + m[5] * (g - b))),
    )


@inlined
def mix_second_row(m: Rows, r: Any, g: Any, b: Any) -> Any:
    """The second number of :func:`mix`."""
    r, g, b = to_doubles(r), to_doubles(g), to_doubles(b)
    return from_doubles(g + (m[2] * (r - g) + m[3] * (b - g)))
