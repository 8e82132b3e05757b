"""Stretch numbers of any range to 0..1."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64


def finite_range(values: npt.NDArray[np.floating], percentiles: tuple[float, float] = (0, 100)) -> tuple[float, float]:
    """Return the values at two percentiles, the least and the greatest by default, of those that are finite.

    Both are 0 where no value is finite.
    """
    known: Float64 = values[np.isfinite(values)].astype(np.float64)
    if not known.size:
        return 0.0, 0.0
    low, high = np.percentile(known, percentiles)
    return float(low), float(high)


def stretched(values: npt.NDArray[np.float32], low: float, high: float) -> Array:
    """Return float32 of the same shape: 0 at ``low``, 1 at ``high``, cut off beyond; NaN becomes 0.

    Where ``low`` is ``high`` there is nothing to stretch, and values stay as they are.
    """
    with np.errstate(all="ignore"):  # an Inf stays one, and is cut off
        part = values.astype(np.float64)
        if high > low:
            part = (part - low) / (high - low)
    return np.nan_to_num(part, nan=0.0, posinf=1.0, neginf=0.0).clip(0, 1).astype(np.float32)


def grey(values: Array) -> Array:
    """Return (H, W, 3) codes of a grey, (H, W)."""
    return np.repeat(values[..., None], 3, axis=2)
