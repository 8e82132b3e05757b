"""Measure what the paper claims in words: connected lines, found contours, coherence.

Lines are (H, W), 1 paper and 0 ink; below one half is ink.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage  # type: ignore[import-untyped]

_EIGHT = np.ones((3, 3), int)  # ink that touches at a corner is one line; paper is not one side of it then


class Ink(NamedTuple):
    """The connected pieces of a drawing."""

    pieces: int
    mean_size: float  # pixels; 0 without ink
    largest: int


class Found(NamedTuple):
    """How well ink meets a contour."""

    f_score: float  # harmonic mean of the two
    precision: float  # of the ink, how much lies at the contour
    recall: float  # of the contour, how much lies at ink


def is_ink(lines: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return whether each pixel of a drawing is ink."""
    return np.asarray(lines) < 0.5


def ink_components(lines: npt.ArrayLike) -> Ink:
    """Return the 8-connected pieces of ink: fewer and larger pieces make a more coherent drawing."""
    labels, count = ndimage.label(is_ink(lines), _EIGHT)
    sizes = np.bincount(labels.ravel())[1:]
    return Ink(int(count), float(sizes.mean()) if count else 0.0, int(sizes.max()) if count else 0)


def is_closed_ring(lines: npt.ArrayLike, centre: tuple[float, float], radius: float, tolerance: float = 3.0) -> bool:
    """Return whether ink is one piece, within ``tolerance`` px of a circle about (x, y), that shuts the centre in."""
    ink = is_ink(lines)
    y, x = np.mgrid[: ink.shape[0], : ink.shape[1]]
    off = np.abs(np.hypot(x - centre[0], y - centre[1]) - radius)
    sides, _ = ndimage.label(~ink)  # 4-connected: a diagonal step of ink is shut
    inside = sides[round(centre[1]), round(centre[0])]
    shut = bool(inside != 0 and inside != sides[0, 0])
    return ink_components(lines).pieces == 1 and bool((off[ink] <= tolerance).all()) and shut


def f_score(lines: npt.ArrayLike, contour: npt.ArrayLike, tolerance: float = 2.5) -> Found:
    """Compare ink with the pixels of a true contour; pixels match within ``tolerance`` pixels."""
    ink, true = is_ink(lines), np.asarray(contour, bool)
    if not ink.any() or not true.any():
        return Found(0.0, 0.0, 0.0)
    precision = float((_distance(true)[ink] <= tolerance).mean())
    recall = float((_distance(ink)[true] <= tolerance).mean())
    total = precision + recall
    return Found(2 * precision * recall / total if total else 0.0, precision, recall)


def cells_kept(lines: npt.ArrayLike, drawing: npt.ArrayLike) -> float:
    """Return the share of the white cells of a drawn net (code values) that are still separate cells in its lines.

    A cell is lost when its paper runs into another's, through a gap in the ink, or when it has none left.
    """
    cells, count = ndimage.label(np.asarray(drawing) >= 200)
    paper, _ = ndimage.label(~is_ink(lines))
    sizes = np.bincount(cells.ravel(), minlength=count + 1)
    owner = [np.bincount(paper[cells == c]) for c in range(1, count + 1) if sizes[c] >= 8]  # fragments at the border
    main = [int(pieces[1:].argmax()) + 1 if pieces.size > 1 else 0 for pieces in owner]
    kept = sum(piece > 0 and main.count(piece) == 1 for piece in main)
    return kept / len(main)


def _distance(places: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Return each pixel's distance in pixels to the nearest pixel of a mask."""
    distance: npt.NDArray[Any] = ndimage.distance_transform_edt(~places)
    return distance


def flicker(one: npt.ArrayLike, other: npt.ArrayLike) -> float:
    """Return how much a drawing changes with the noise: mean |difference| over mean ink of two drawings of one frame.

    0 is steady, 2 shares no ink. The frame comes with two draws of noise, sigma 2 of 255 (see ``compare.under_noise``).
    """
    a, b = np.asarray(one, np.float64), np.asarray(other, np.float64)
    ink = 1 - (a + b).mean() / 2
    return float(np.abs(a - b).mean() / ink) if ink > 0 else 0.0


def jag(lines: npt.ArrayLike, sigma: float = 2.0, edge: float = 0.1) -> float:
    """Return the jaggedness of ink in degrees: the mean angle between a stroke's edge and its direction round about.

    At each pixel where the gradient (Sobel / 8) of the matte is above ``edge`` per pixel, the angle, 0 to 90 degrees,
    between its normal and the main normal of the structure tensor, averaged with a Gaussian of ``sigma`` pixels. A
    straight anti-aliased edge has about 0, a black-and-white one at a slope about 10. No ink has 0.
    """
    gx, gy = _gradient(lines)
    xx, xy, yy = (ndimage.gaussian_filter(product, sigma) for product in (gx * gx, gx * gy, gy * gy))
    main = np.arctan2(2 * xy, xx - yy) / 2
    at = np.hypot(gx, gy) > edge
    turn = np.arctan2(gy, gx)[at] - main[at]
    return float(np.degrees(np.abs((turn + np.pi / 2) % np.pi - np.pi / 2)).mean()) if at.any() else 0.0


def psnr(result: npt.ArrayLike, clean: npt.ArrayLike) -> float:
    """Return the peak signal-to-noise ratio in dB, of 8-bit display values (0 to 255)."""
    error = ((np.asarray(result, np.float64) - np.asarray(clean, np.float64)) ** 2).mean()
    return float(10 * np.log10(255**2 / error)) if error else np.inf


def edge_error(result: npt.ArrayLike, clean: npt.ArrayLike, edge: float = 8.0, reach: int = 2) -> float:
    """Return the error of restored edges: mean length of the gradient's error over mean length of the true gradient.

    Both of one channel in values of 0 to 255, at pixels within ``reach`` of where the clean picture's gradient
    (Sobel / 8) is above ``edge`` per pixel. 0 is perfect; 1 is as bad as no edge at all.
    """
    (rx, ry), (cx, cy) = _gradient(result), _gradient(clean)
    true = np.hypot(cx, cy)
    at = ndimage.binary_dilation(true > edge, _EIGHT, iterations=reach)
    return float(np.hypot(rx - cx, ry - cy)[at].sum() / true[at].sum()) if at.any() else 0.0


def _gradient(plane: npt.ArrayLike) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Return the gradient along x and y, per pixel: Sobel / 8, border repeated."""
    values = np.asarray(plane, np.float64)
    return ndimage.sobel(values, 1, mode="nearest") / 8, ndimage.sobel(values, 0, mode="nearest") / 8
