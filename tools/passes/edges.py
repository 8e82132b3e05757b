"""Hold lines to the true edges of a scene, which were found in a render of four times the size.

A file of truth, ``edges.####.npz``, has ``silhouette`` and ``crease``, packed bits of ``shape`` (4H, 4W), and for each
pixel of ``silhouette`` in order, ``outward``: the direction x, y that leads off the surface in front, int8 of 127.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage  # type: ignore[import-untyped]

Plane = npt.NDArray[Any]

SCALE = 4  # of the truth, in each direction
NEAR = 1.5  # px within which an edge counts as drawn
AT_AN_EDGE = 2.0  # px within which ink counts as drawn where an edge is
REACH = 6.0  # px that a silhouette is looked at on either side


@dataclass(frozen=True)
class Found:
    """How lines meet the true edges of one frame."""

    recall: float  # of the silhouettes, how much lies within NEAR of ink
    crease: float  # the same of creases; NaN where there are none
    precision: float  # of the ink, how much lies within AT_AN_EDGE of an edge
    width: float  # px, the median over silhouettes that stand alone
    spread: float  # px, the width's 90th percentile less its 10th
    inner: float  # of that ink, how much lies on the surface in front
    double: float  # of those silhouettes, how many are drawn more than once
    ink: float  # of the picture


@dataclass(frozen=True)
class Truth:
    """The true edges of a frame, (4H, 4W) bool; of each silhouette pixel the direction off the surface in front."""

    silhouette: npt.NDArray[np.bool_]
    crease: npt.NDArray[np.bool_]
    outward: Plane

    @classmethod
    def load(cls, path: Path) -> Truth:
        """Read a file of truth."""
        with np.load(path) as held:
            height, width = (int(each) for each in held["shape"])
            silhouette, crease = (
                np.unpackbits(held[name], count=height * width).reshape(height, width).astype(bool)
                for name in ("silhouette", "crease")
            )
            return cls(silhouette, crease, held["outward"].astype(np.float64) / 127)

    @cached_property
    def distance(self) -> Plane:
        """Return each pixel's distance to the nearest edge in pixels of the lines, (H, W)."""
        distance: Plane = ndimage.distance_transform_edt(~(self.silhouette | self.crease))
        return distance[SCALE // 2 :: SCALE, SCALE // 2 :: SCALE] / SCALE

    @cached_property
    def alone(self) -> Plane:
        """Return the places among silhouette pixels of every fifth whose neighbourhood has no other edge."""
        y, x = np.nonzero(self.silhouette)
        steps = np.arange(-REACH * SCALE, REACH * SCALE + 1)
        edge = self.silhouette | self.crease
        rows = np.rint(y[:, None] - steps * self.outward[:, 1:]).astype(int).clip(0, edge.shape[0] - 1)
        columns = np.rint(x[:, None] - steps * self.outward[:, :1]).astype(int).clip(0, edge.shape[1] - 1)
        others = edge[rows, columns][:, np.abs(steps) > SCALE + 1].any(axis=1)
        return np.nonzero(~others)[0][::5]

    def compare(self, lines: npt.ArrayLike) -> Found:
        """Return how lines, (H, W), meet these edges."""
        ink = 1 - np.asarray(lines, np.float64)
        drawn = ink >= 0.5
        off = ndimage.distance_transform_edt(~drawn) if drawn.any() else np.full(ink.shape, np.inf)
        sides = np.arange(-REACH, REACH + 0.01, 1 / SCALE)  # px, inward above 0
        y, x = (each[self.alone, None] for each in np.nonzero(self.silhouette))
        across = self.outward[self.alone]
        profiles = _at(ink, y - SCALE * sides * across[:, 1:], x - SCALE * sides * across[:, :1])
        profiles = profiles[profiles.max(axis=1, initial=0) > 0.5]
        widths = profiles.sum(axis=1) / SCALE
        inside = profiles[:, sides >= -1 / SCALE].sum(axis=1) / profiles.sum(axis=1)
        above = profiles > 0.5
        runs = above[:, 0] + (above[:, 1:] & ~above[:, :-1]).sum(axis=1)
        tenth, median, ninth = np.percentile(widths, (10, 50, 90)) if widths.size else [np.nan] * 3
        return Found(
            recall=_share(_at(off, *np.nonzero(self.silhouette)) <= NEAR),
            crease=_share(_at(off, *np.nonzero(self.crease)) <= NEAR),
            precision=float(ink[self.distance <= AT_AN_EDGE].sum() / ink.sum()) if ink.sum() else np.nan,
            width=float(median),
            spread=float(ninth - tenth),
            inner=_share(inside),
            double=_share(runs > 1),
            ink=float(ink.mean()),
        )


def mean(found: list[Found]) -> Found:
    """Return the mean over frames; a number that some frame has not is of the others."""
    numbers = np.array([astuple(each) for each in found])
    known = np.isfinite(numbers)
    sums = np.where(known, numbers, 0).sum(axis=0)
    return Found(*np.divide(sums, known.sum(axis=0), out=np.full(sums.shape, np.nan), where=known.any(axis=0)).tolist())


def table(rows: dict[str, Found]) -> str:
    """Return rows of numbers under their names, as text."""
    names = [each.name for each in fields(Found)]
    lines = [f"{'':12}" + "".join(f"{name:>10}" for name in names)]
    lines += [f"{label:12}" + "".join(f"{number:10.3f}" for number in astuple(each)) for label, each in rows.items()]
    return "\n".join(lines)


def _at(plane: Plane, y: Plane, x: Plane) -> Plane:
    """Read a plane of the lines' size at places of the truth."""
    places = [(y + 0.5) / SCALE - 0.5, (x + 0.5) / SCALE - 0.5]
    read: Plane = ndimage.map_coordinates(plane, places, order=1, mode="nearest")
    return read


def _share(where: Plane) -> float:
    return float(where.mean()) if where.size else np.nan
