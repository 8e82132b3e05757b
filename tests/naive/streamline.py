"""Streamlines of the flow, samples along them, and eq. 11 (section 3.3), for all pixels at once, in float64."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]


def centres(shape: tuple[int, ...]) -> tuple[Float64, Float64]:
    """Return x and y of the centre of every pixel, (H, W) each."""
    y, x = np.mgrid[: shape[0], : shape[1]].astype(np.float64)
    return x, y


def nearest(image: Float64, dx: Float64, dy: Float64) -> Float64:
    """Return, for each pixel, the pixel of ``image`` nearest to the point (dx, dy) away; the border is repeated."""
    x, y = centres(image.shape)
    column = np.clip(x + np.rint(dx), 0, image.shape[1] - 1).astype(int)
    row = np.clip(y + np.rint(dy), 0, image.shape[0] - 1).astype(int)
    return image[row, column]


def bilinear(image: Float64, dx: Float64, dy: Float64) -> Float64:
    """Return, for each pixel, the bilinear sample of ``image`` at the point (dx, dy) away; the border is repeated."""
    x, y = centres(image.shape)
    height, width = image.shape[:2]
    x, y = np.clip(x + dx, 0, width - 1), np.clip(y + dy, 0, height - 1)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    right, bottom = np.minimum(left + 1, width - 1), np.minimum(top + 1, height - 1)
    extra = (1,) * (image.ndim - 2)
    u, v = (x - left).reshape(x.shape + extra), (y - top).reshape(y.shape + extra)
    return (1 - v) * ((1 - u) * image[top, left] + u * image[top, right]) + v * (
        (1 - u) * image[bottom, left] + u * image[bottom, right]
    )


READ = {"nearest": nearest, "bilinear": bilinear}


def curve(flow: npt.ArrayLike, steps: int, way: int) -> Iterator[tuple[Float64, Float64, Float64]]:
    """Follow the flow axis c_x of every pixel x, along the tangent (``way`` 1) or against it (-1).

    Yields (dx, dy, t) after each of the steps 1 .. ``steps``: z - x, (H, W) each, and t(z), (H, W, 2).
    """
    flow = np.asarray(flow, np.float64)
    t = way * flow
    dx, dy = np.zeros(flow.shape[:2]), np.zeros(flow.shape[:2])
    for _ in range(steps):
        dx, dy = dx + t[..., 0], dy + t[..., 1]
        there = nearest(flow, dx, dy)
        t = np.where((there * t).sum(-1, keepdims=True) < 0, -there, there)
        yield dx, dy, t


def gaussian(sigma: float, steps: int) -> Float64:
    """Return G_sigma at -steps .. steps, with sum 1."""
    s = np.arange(-steps, steps + 1)
    weights = np.exp(-(s**2) / (2 * sigma**2)) if sigma > 0 else (s == 0).astype(float)  # eq. 7
    return weights / weights.sum()


def along(image: npt.ArrayLike, flow: npt.ArrayLike, sigma: float, sampling: str) -> Float64:
    """Return the sum of ``image`` along c_x, weighted by G_sigma and cut at ceil(3 sigma)."""
    image = np.asarray(image, np.float64)
    steps = int(np.ceil(3 * sigma))
    weights = gaussian(sigma, steps)
    total = weights[steps] * image
    for way in (1, -1):
        for s, (dx, dy, _) in enumerate(curve(flow, steps, way), 1):
            total = total + weights[steps + way * s] * READ[sampling](image, dx, dy)  # eq. 11
    return total
