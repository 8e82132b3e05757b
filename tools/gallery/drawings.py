"""Draw inputs by code: points, a disc in noise, a fine texture; and damage photographs.

Drawings are code values, (H, W) float32, white 255; :func:`scene_linear` turns them into what a plate holds.
Photographs are display-referred, (H, W, 3) uint8. The same arguments give the same bits.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio
from scipy.spatial import cKDTree  # type: ignore[import-untyped]

from flowabs_nodes.color import lstar_inverse

Array = npt.NDArray[np.float32]
Bytes = npt.NDArray[np.uint8]

SIZE = 200  # of a drawing, width and height
CENTRE = (SIZE - 1) / 2
RING = 60.0  # radius of the circle of dots, and of the disc
SPACING = 13.5  # from dot to dot, about that of 28 dots on the circle


def dots(points: Iterable[tuple[float, float]], radius: float = 3.0, size: int = SIZE) -> Array:
    """Draw black dots on white, anti-aliased, around the points (x, y)."""
    y, x = np.mgrid[:size, :size]
    cover = np.zeros((size, size))
    for px, py in points:
        cover = np.maximum(cover, np.clip(radius + 0.5 - np.hypot(x - px, y - py), 0, 1))
    return np.asarray(255 * (1 - cover), np.float32)


def dots_on_circle(count: int = 28, ring: float = RING) -> Array:
    """Draw Fig. 8a: isolated dots on a circle."""
    angles = 2 * np.pi * np.arange(count) / count
    return dots((CENTRE + ring * np.cos(a), CENTRE + ring * np.sin(a)) for a in angles)


def dots_x(arm: int = 7, spacing: float = SPACING) -> Array:
    """Draw Fig. 8d: an X of 29 dots, one in the middle and seven on each diagonal arm."""
    step = spacing / np.sqrt(2)
    return dots(
        [(CENTRE, CENTRE)]
        + [
            (CENTRE + sx * k * step, CENTRE + sy * k * step)
            for k in range(1, arm + 1)
            for sx in (-1, 1)
            for sy in (-1, 1)
        ]
    )


def dots_t(half_bar: int = 5, stem: int = 8, spacing: float = SPACING) -> Array:
    """Draw Fig. 8g: a T of 19 dots, a bar of eleven and a stem of eight."""
    top = CENTRE - stem * spacing / 2
    bar = [(CENTRE + k * spacing, top) for k in range(-half_bar, half_bar + 1)]
    return dots(bar + [(CENTRE, top + k * spacing) for k in range(1, stem + 1)])


def disc_in_noise(seed: int = 0, sigma: float = 40.0, disc: float = 90.0, ground: float = 160.0) -> Array:
    """Draw Fig. 9a: a dark disc under Gaussian noise, sigma in code values."""
    y, x = np.mgrid[:SIZE, :SIZE]
    cover = np.clip(RING + 0.5 - np.hypot(x - CENTRE, y - CENTRE), 0, 1)
    clean = ground + (disc - ground) * cover
    return np.asarray(clean + sigma * np.random.default_rng(seed).standard_normal(clean.shape), np.float32)


def disc_contour() -> npt.NDArray[np.bool_]:
    """Return the true contour of :func:`disc_in_noise`: the pixels that the circle passes through."""
    y, x = np.mgrid[:SIZE, :SIZE]
    return np.asarray(np.abs(np.hypot(x - CENTRE, y - CENTRE) - RING) < 0.5)


def small_texture(period: float = 8.0, width: float = 1.0, seed: int = 1) -> Array:
    """Draw Fig. 10a: a fine net without direction, black lines of ``width`` around cells ``period`` apart.

    The cells are those of a hexagonal lattice whose points are jittered by a quarter of the period.
    """
    points = _jittered_lattice(period, seed)
    y, x = np.mgrid[:SIZE, :SIZE]
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    distance, nearest = cKDTree(points).query(pixels, k=4)
    # To the borders with the next three cells: half of the difference of squares, over the distance of the two points.
    apart = np.linalg.norm(points[nearest[:, :1]] - points[nearest[:, 1:]], axis=2)
    border = ((distance[:, 1:] ** 2 - distance[:, :1] ** 2) / (2 * apart)).min(axis=1).reshape(SIZE, SIZE)
    return np.asarray(255 * (1 - np.clip(width / 2 + 0.5 - border, 0, 1)), np.float32)


def _jittered_lattice(period: float, seed: int) -> npt.NDArray[np.float64]:
    row = period * np.sqrt(3) / 2
    rows, columns = range(-2, int(SIZE / row) + 3), range(-2, int(SIZE / period) + 3)
    points = np.array([((i + j % 2 / 2) * period, j * row) for j in rows for i in columns])
    return points + np.random.default_rng(seed).uniform(-period / 4, period / 4, points.shape)


def scene_linear(code: npt.ArrayLike) -> Array:
    """Return the grey plate (H, W, 3) whose code values (L* x 2.55) are ``code``."""
    lstar = np.asarray(code, np.float32) / np.float32(2.55)
    grey = np.asarray(lstar_inverse(lstar), np.float32)
    plate: Array = np.repeat(grey[:, :, np.newaxis], 3, axis=2)
    return plate


def noisy(photo: Bytes, sigma: float = 20.0, seed: int = 0) -> Bytes:
    """Add Gaussian noise to a photograph, sigma in 8-bit display values, rounded and clipped as by a camera."""
    noise = sigma * np.random.default_rng(seed).standard_normal(photo.shape)
    return np.clip(np.rint(photo + noise), 0, 255).astype(np.uint8)


def jpeg_damaged(photo: Bytes, quality: int = 10) -> Bytes:
    """Return a photograph (H, W, 3) after JPEG compression of this quality, 1 to 100."""
    height, width, channels = photo.shape
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "photo.jpg")
        spec = oiio.ImageSpec(width, height, channels, "uint8")
        spec.attribute("Compression", f"jpeg:{quality}")
        output = oiio.ImageOutput.create(path)
        if not (output and output.open(path, spec) and output.write_image(photo) and output.close()):
            raise OSError(f"{path}: {oiio.geterror()}")
        file = oiio.ImageInput.open(path)
        if file is None:
            raise OSError(f"{path}: {oiio.geterror()}")
        damaged = np.asarray(file.read_image("uint8"))
        file.close()
    return damaged
