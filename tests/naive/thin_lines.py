"""Mirror thin bright lines at their ground, in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.fdog import along, smoothstep
from tests.naive.streamline import bilinear


def _across(pick, plane, flow, length):
    """Return the extremum over a segment across the flow, sampled at steps of at most a pixel."""
    half = length / 2
    points = int(np.ceil(half))
    size = np.hypot(flow[..., 0], flow[..., 1])[..., None]
    t = np.divide(flow, size, out=np.zeros_like(flow), where=size > 0)
    result = plane
    for n in range(1, points + 1):
        for side in (1, -1):
            far = side * half * n / points
            result = pick(result, bilinear(plane, far * t[..., 1], -far * t[..., 0]))
    return result


def opening(plane, flow, length):
    """Return the opening of (H, W) across the flow."""
    return _across(np.maximum, _across(np.minimum, plane, flow, length), flow, length)


def closing(plane, flow, length):
    """Return the closing of (H, W) across the flow."""
    return _across(np.minimum, _across(np.maximum, plane, flow, length), flow, length)


def mirror(lightness, flow, width):
    """Return what makes dark lines of the thin bright ones, (H, W)."""
    q, flow = np.asarray(lightness, np.float64), np.asarray(flow, np.float64)
    thin = np.maximum(q - opening(closing(q, flow, 2 * width), flow, width), 0)
    wide = np.maximum(q - opening(q, flow, 2 * width), 0)
    thin_along, wide_along = (along(each, flow, 2 * width, "nearest") for each in (thin, wide))
    share = smoothstep(0.55, 0.75, thin_along / np.maximum(wide_along, 1e-3))
    return -2 * share * smoothstep(8, 20, thin_along) * np.minimum(wide, 3 * thin)
