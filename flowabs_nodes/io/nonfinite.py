"""Count NaN and Inf in a plate, and repair them from their neighbours or refuse the plate."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ReadError
from flowabs_nodes.simd.bands import over_rows


def count(pixels: npt.NDArray[np.floating]) -> tuple[int, int]:
    """Return how many values are NaN, and how many are Inf."""
    if all(over_rows(lambda first, last: _sum_is_finite(pixels[first:last]), len(pixels))):
        return 0, 0
    nans = int(np.isnan(pixels).sum())
    return nans, int(pixels.size - nans - np.isfinite(pixels).sum())


def _sum_is_finite(rows: npt.NDArray[np.floating]) -> bool:
    """Return whether numbers are finite, from one pass without a copy: of finite float32 the sum in float64 is."""
    with np.errstate(invalid="ignore"):  # Inf - Inf
        return math.isfinite(float(rows.sum(dtype=np.float64)))


def said(nans: int, infs: int) -> str:
    """Return both counts for a message: "6 NaN and 12 Inf"; what there is none of is left out."""
    return " and ".join(f"{number} {what}" for number, what in ((nans, "NaN"), (infs, "Inf")) if number)


def finite(pixels: Array, how: str) -> Array:
    """Return (H, W, C) pixels that are finite; ReadError for others, which became so ``how``: "over its alpha"."""
    if count(pixels) != (0, 0):
        bad = ~np.isfinite(pixels).all(axis=2)
        y, x = np.argwhere(bad)[0]
        number = int(bad.sum())
        found = f"{number} {'pixel' if number == 1 else 'pixels'}"
        raise ReadError(f"its colour {how} is NaN or Inf in {found}, the first at x {x}, y {y}", code="non-finite")
    return pixels


def repaired(pixels: Array, policy: str) -> tuple[Array, str]:
    """Return (H, W, C) pixels without NaN and Inf, and what to say about it in the log ("" for nothing).

    Each NaN or Inf is replaced by the mean of the finite values among its 3x3 neighbours (OpenImageIO's fixNonFinite),
    from the first pixel to the last; by 0 where nothing at all is finite. With the policy "error" ReadError is raised
    instead.
    """
    nans, infs = count(pixels)
    if not nans and not infs:
        return pixels, ""
    found = said(nans, infs)
    if policy == "error":
        raise ReadError(f"{found} in its pixels", code="non-finite", hint='nonfinite: "repair"', parameter="nonfinite")
    buf = oiio.ImageBuf(pixels)
    # One thread: with several the result depends on how they share the work.
    fixed = oiio.ImageBufAlgo.fixNonFinite(buf, oiio.NONFINITE_BOX3, nthreads=1)
    result = np.asarray(fixed.get_pixels(oiio.FLOAT), np.float32).reshape(pixels.shape)
    black = ~np.isfinite(result)
    if black.any():
        result[black] = 0
    return result, f"{found} repaired from their neighbours" + (f", {int(black.sum())} set to 0" if black.any() else "")
