"""The isotropic difference of Gaussians, the edge model that the paper builds on and compares itself with."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.gaussian_blur import separable


def dog(code: npt.ArrayLike, sigma_c: float = 1.0, rho: float = 0.99) -> Array:
    """Return the response of the isotropic DoG: H = G(sigma_c) * I - rho G(1.6 sigma_c) * I, eq. 8 in two dimensions.

    Parameters
    ----------
    code
        Code values, (H, W).
    sigma_c
        Sigma of the inner Gaussian in pixels, above 0, at most 10,000: the width of lines. Both Gaussians are cut at
        ceil(3 * 1.6 sigma_c), the border repeated.
    rho
        Weight of the outer Gaussian, 0 to 2. Where code values are constant, H = (1 - rho) I.

    Returns
    -------
    H in code values, (H, W) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    code = validate.plane("code", code)
    sigma_c = validate.number("sigma_c", sigma_c, above=0, max=10_000)
    rho = validate.number("rho", rho, min=0, max=2)
    centre, surround = gaussian.centre_and_surround(sigma_c)
    return separable(code, centre) - np.float32(rho) * separable(code, surround)  # eq. 8: in two dimensions
