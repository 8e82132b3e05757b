"""Measure how lines or colours change from frame to frame: with noise (boil), along the motion, and too slowly (ghost).

Pictures are planes, (H, W): ink 0..1, or code values. The motion of a frame is (H, W, 4) in Blender's convention:
(x + X, y - Y) is a pixel's place on the frame before, (x - Z, y + W) that on the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage  # type: ignore[import-untyped]

Plane = npt.NDArray[Any]

BLUR = 1.0  # px, the sigma of what both pictures are blurred by: resampling alone changes thin lines by .09 of the ink
CHANGED = 4.0  # code values: what a plate that differs more along its motion has really changed by
DEPTH_TOLERANCE = 0.05  # of the depth


def boil(one: npt.ArrayLike, other: npt.ArrayLike) -> float:
    """Return mean |difference| over mean ink of a frame that was drawn from two draws of noise; 0 is steady."""
    a, b = np.asarray(one, np.float64), np.asarray(other, np.float64)
    ink = (a.mean() + b.mean()) / 2
    return float(np.abs(a - b).mean() / ink) if ink else 0.0


@dataclass(frozen=True)
class Step:
    """From one frame to the next: where each pixel of the later one was, and where that can be compared.

    ``still`` is where the scene is seen on both and its shading is the same, ``changed`` where shading really changed,
    as a shadow does that moves on.
    """

    before: Plane
    still: npt.NDArray[np.bool_]
    changed: npt.NDArray[np.bool_]

    @classmethod
    def between(cls, motion: tuple[Plane, Plane], depth: tuple[Plane, Plane], plate: tuple[Plane, Plane]) -> Step:
        """Compare a frame with the next: their motions, depths, (H, W), and code values without noise, (H, W)."""
        (motion_before, motion_here), (depth_before, depth_here) = motion, depth
        here = _grid(depth_here.shape)
        before = here + np.stack([motion_here[..., 0], -motion_here[..., 1]])
        forward = np.stack([warped(-motion_before[..., 2], before, 0), warped(motion_before[..., 3], before, 0)])
        seen = np.linalg.norm(before + forward - here, axis=0) <= 1
        seen &= np.abs(warped(depth_before, before, 0) - depth_here) <= DEPTH_TOLERANCE * depth_here
        limits = np.array(depth_here.shape)[::-1, None, None] - 1
        seen &= ((before >= 0) & (before <= limits)).all(axis=0)
        was, now = (ndimage.gaussian_filter(each, 1.5 * BLUR) for each in plate)
        changed = ndimage.binary_dilation(np.abs(now - warped(was, before)) > CHANGED, np.ones((5, 5)))
        still = ndimage.binary_erosion(seen, np.ones((3, 3)), border_value=1) & ~changed
        return cls(before, still, changed)

    def change(self, before: Plane, here: Plane) -> float:
        """Return mean |difference| of two frames along the motion, both blurred, over the still part."""
        return mean_over(np.abs(_blurred(here) - warped(_blurred(before), self.before)), self.still)

    def ghost(self, steady: Plane, alone: Plane) -> float:
        """Return mean |difference| of a steady picture from the one of the frame alone, where the scene changed."""
        return mean_over(np.abs(_blurred(steady) - _blurred(alone)), self.changed)

    def difference(self, before: Plane, here: Plane) -> Plane:
        """Return |difference| along the motion for looking at, (H, W); 0 where it cannot be compared."""
        return np.where(self.still, np.abs(here - warped(before, self.before)), 0)


def warped(plane: Plane, places: Plane, order: int = 1) -> Plane:
    """Read a plane at ``places``, (2, H, W) of x, y: bilinearly, or of the nearest pixel with ``order`` 0."""
    read: Plane = ndimage.map_coordinates(np.asarray(plane, np.float64), places[::-1], order=order, mode="nearest")
    return read


def mean_over(plane: Plane, where: Plane) -> float:
    """Return the mean of a plane where a mask is True; 0 where it is nowhere."""
    return float(plane[where].mean()) if where.any() else 0.0


def _grid(shape: tuple[int, ...]) -> Plane:
    y, x = np.indices(shape[:2], np.float64)
    return np.stack([x, y])


def _blurred(plane: Plane) -> Plane:
    blurred: Plane = ndimage.gaussian_filter(np.asarray(plane, np.float64), BLUR)
    return blurred
