"""Depth as a number u that is an affine function of the pixel on every plane, and larger for what is nearer.

With perspective, 1/Z is affine in x and y for the points of a plane, Z measured along the camera's axis ("planar"). A
*distance* D from the camera's eye is Z / cos(theta), theta the angle between the ray and the axis. With an orthographic
camera Z itself is affine.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.background import BACKGROUND
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import kernel

#: The largest half: what is further away may have become background in a file of halves. It counts as background, as do
#: depths that are not finite or not above 0.
HALF_MAX = 65504.0

_LARGEST = 1e30  # of u either way: differences of such numbers are finite


class View(NamedTuple):
    """Where a camera's axis meets the picture, and how wide the picture is, in pixels of the array."""

    center_x: float
    center_y: float
    width: float  # of the display window
    pixel_aspect: float = 1.0  # width of a pixel over its height


class Depth(NamedTuple):
    """Affine depth u, (H, W) float32, and what u means."""

    u: Array
    far: float  # u of the background, and of nothing else
    unknown: float  # u beyond which a file of halves has nothing but background


def no_depth() -> Depth:
    """Return what stands for a depth pass where there is none."""
    return Depth(np.empty((0, 0), np.float32), 0.0, 0.0)


def affine_depth(depth: Array, projection: str, field_of_view: float, view: View) -> Depth:
    """Return the affine depth of a pass.

    Parameters
    ----------
    depth
        (H, W) float32, any numbers: NaN, Inf and numbers that are not above 0 are background.
    projection
        "planar", "distance" or "orthographic".
    field_of_view
        Angle that the view's width covers, in degrees; read with "distance" alone.
    view
        The camera's axis in the picture; read with "distance" alone.

    Raises ArgumentError where all depths are behind the camera.
    """
    if not (depth > 0).any() and (depth < 0).any():
        raise ArgumentError(
            "depth: expected distances, found negative numbers alone", hint="multiply it by -1", parameter="depth"
        )
    u = np.empty_like(depth)
    if projection == "orthographic":
        over_rows(_negated, depth.shape[0], depth, u)
        return Depth(u, -_LARGEST, -_LARGEST)
    slope = 2 * math.tan(math.radians(field_of_view) / 2) / view.width if projection == "distance" else 0.0
    over_rows(_inverted, depth.shape[0], depth, slope, view, u)
    return Depth(u, 0.0, 1 / HALF_MAX)


@kernel
def _inverted(first: int, last: int, depth: Array, slope: float, view: View, u: Array) -> None:
    """Write u = 1/Z, Z = D cos(theta), of the rows ``first`` .. ``last`` - 1; 0 is the background.

    ``slope`` is the tangent of the angle that a pixel beside the axis covers, 0 where depths are Z already.
    """
    for y in range(first, last):
        v = slope * (y - view.center_y) / view.pixel_aspect
        for x in range(depth.shape[1]):
            z = depth[y, x]
            h = slope * (x - view.center_x)
            solid = z > 0 and z < BACKGROUND and z != HALF_MAX
            inverse = (
                math.sqrt(1 + h * h + v * v) / z if slope != 0 else 1 / np.float64(z)
            )  # 1/cos(theta) = |(h, v, 1)|
            u[y, x] = np.float32(min(inverse, _LARGEST)) if solid else np.float32(0)


@kernel
def _negated(first: int, last: int, depth: Array, u: Array) -> None:
    """Write u = -Z of the rows ``first`` .. ``last`` - 1."""
    for y in range(first, last):
        for x in range(depth.shape[1]):
            z = depth[y, x]
            solid = z > 0 and z < BACKGROUND and z != HALF_MAX
            u[y, x] = -z if solid else np.float32(-_LARGEST)
