"""XDoG: another parametrisation of the difference of Gaussians, whose lines fade into tone.

Winnemöller, Kyprianidis, Olsen: "XDoG: An eXtended difference-of-Gaussians compendium", Computers & Graphics 36(6),
2012. There D = (1 + p) G_sigma - p G_1.6sigma, the picture sharpened p times: (1 + p) (G_sigma - rho G_1.6sigma) with
rho = p / (1 + p). With this rho, D / (1 + p) is the response H of this package.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel


def xdog(response: npt.ArrayLike, p: float = 20.0, epsilon: float = 0.0, phi: float = 0.01) -> tuple[Array, Array]:
    """Draw lines and tone: 1 where D >= epsilon, else 1 + tanh(phi (D - epsilon)).

    Parameters
    ----------
    response
        H of :func:`~flowabs_nodes.filters.dog` or :func:`~flowabs_nodes.filters.fdog` with the rho that
        :func:`xdog_rho` returns; (H, W), code values.
    p
        Strength of the sharpening, 0 to 10,000: 0 is tone alone, higher draws stronger edges.
    epsilon
        Level in code values below which tone darkens. At 0 only edges do, at 255 all but their bright sides.
    phi
        Steepness of the ramp to black per code value, at least 0. The paper's intensities are 0 to 1, so its phi is
        255 times this one.

    Returns
    -------
    Lines, (H, W) float32, 1 paper and 0 ink, and D in code values.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    response = validate.plane("response", response)
    gain = 1 + validate.number("p", p, min=0, max=10_000)
    epsilon = validate.number("epsilon", epsilon)
    phi = validate.number("phi", phi, min=0)
    lines, sharpened = np.empty_like(response), np.empty_like(response)
    over_rows(_xdog, response.shape[0], response, gain, epsilon, phi, lines, sharpened)
    return lines, sharpened


def xdog_rho(p: float) -> float:
    """Return the rho for which H is D / (1 + p): p / (1 + p)."""
    p = validate.number("p", p, min=0, max=10_000)
    return p / (1 + p)


@kernel
def _xdog(
    first: int, last: int, response: Array, gain: float, epsilon: float, phi: float, lines: Array, sharpened: Array
) -> None:
    """Write rows ``first`` .. ``last`` - 1 of lines and of D = ``gain`` H, clamped to float32's range."""
    largest = np.float64(np.finfo(np.float32).max)
    for y in range(first, last):
        for x in range(response.shape[1]):
            d = min(max(gain * response[y, x], -largest), largest)
            sharpened[y, x] = d
            lines[y, x] = 1.0 if d >= epsilon else 1.0 + np.tanh(phi * (d - epsilon))
