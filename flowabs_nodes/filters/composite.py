"""Lines laid over a picture in any ink."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.kernels import parallel_kernel


def composite(
    rgb: npt.ArrayLike,
    lines: npt.ArrayLike,
    ink: Sequence[float] = (0.0, 0.0, 0.0),
    opacity: float = 1.0,
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Ink over a picture: rgb (1 - k) + ink A k with k = (1 - lines) opacity.

    Parameters
    ----------
    rgb
        (H, W, 3), premultiplied.
    lines
        (H, W), 1 paper and 0 ink.
    ink
        Three numbers, in the colours of ``rgb``.
    opacity
        0 to 1.
    alpha
        A, (H, W): there is ink only where there is a picture. None is 1 everywhere.

    Returns
    -------
    The picture with lines, (H, W, 3) float32, premultiplied by the same alpha.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    rgb = arguments.planes("rgb", rgb)
    lines = arguments.plane("lines", lines, rgb.shape)
    coverage = (
        np.broadcast_to(np.float32(1), rgb.shape[:2]) if alpha is None else arguments.plane("alpha", alpha, rgb.shape)
    )
    opacity = arguments.number("opacity", opacity, min=0, max=1)
    color = tuple(np.float32(arguments.number("ink", value)) for value in ink)
    if len(color) != 3:
        raise ArgumentError(f"ink: expected three numbers, found {len(color)}", parameter="ink")
    inked = np.empty_like(rgb)
    _composite(rgb, lines, color, np.float32(opacity), coverage, inked)
    return inked


@parallel_kernel
def _composite(rgb: Any, lines: Any, ink: Any, opacity: Any, alpha: Any, inked: Any) -> None:
    height, width, _ = rgb.shape
    for y in prange(height):
        for x in range(width):
            k = (np.float32(1.0) - lines[y, x]) * opacity
            for c in range(3):
                inked[y, x, c] = rgb[y, x, c] * (np.float32(1.0) - k) + ink[c] * alpha[y, x] * k
