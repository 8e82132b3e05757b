"""Gaussian blur along the flow: eq. 11 for any picture."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.sampling.exact_sums import exact_sum
from flowabs_nodes.sampling.modes import SAMPLINGS
from flowabs_nodes.sampling.streamline_tiled import (
    BLOCKS,
    TiledStreamlines,
    advance,
    fraction_beyond,
    new_tiled_streamlines,
    start,
    turn,
)
from flowabs_nodes.sampling.tile_cache import (
    COLUMNS,
    ROWS,
    PlanesShape,
    fill_lattice,
    fill_records,
    fill_tangents,
    over_tiles,
    sample_lattice,
    tile_around,
    tile_capacity,
)
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES
from flowabs_nodes.simd.memory import gather_pairs, gather_quads, load, load_pairs, scratch, store

_SUMS = 4 * BLOCKS  # of each channel


def flow_blur(image: npt.ArrayLike, flow: npt.ArrayLike, sigma: float = 2.0, sampling: str = "bilinear") -> Array:
    """Gaussian blur of each channel along the flow.

    Parameters
    ----------
    image
        (H, W) or (H, W, C) with up to four channels, any scale; RGBA premultiplied.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma
        Standard deviation in pixels along the curve, 0 to 10,000; 0 gives a copy. Cut at ceil(3 sigma).
    sampling
        How the curve is read, "bilinear" or "nearest" pixel.

    Returns
    -------
    The blurred image, float32, of the same shape.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    image = validate.any_channels("image", image)
    flow = validate.flow_field(flow, image.shape)
    sigma = validate.number("sigma", sigma, min=0, max=10_000)
    validate.choice("sampling", sampling, SAMPLINGS)
    if image.ndim == 3 and image.shape[2] > 4:
        raise ArgumentError(f"image: expected up to 4 channels, found {image.shape[2]}", parameter="image")
    if sigma == 0:
        return image.copy()
    blurred = along(as_planes(image), flow, gaussian.half(sigma), sampling)
    return np.ascontiguousarray(np.moveaxis(blurred, 0, -1)).reshape(image.shape)


def as_planes(image: Array) -> Array:
    """(H, W) or (H, W, C) as (C, H, W)."""
    return np.ascontiguousarray(image[None] if image.ndim == 2 else np.moveaxis(image, -1, 0))


def along(planes: Array, flow: Array, weights: npt.NDArray[np.float64], sampling: str) -> Array:
    """The weighted sum of each of up to four planes (C, H, W) over the curve c_x of each pixel (eq. 11).

    ``weights`` are those of the steps 0, 1 .. to either side.
    """
    blurred = over_tiles(_along_nearest if sampling == "nearest" else _along_bilinear, planes, flow, weights)
    return exact_sum(planes, flow, np.ones(1), weights, sampling) if blurred is None else blurred


@kernel
def _along_bilinear(
    first: int, last: int, planes: Any, shape: PlanesShape, flow: Any, weights: Any, blurred: Any
) -> bool:
    """Whether all tangents were short enough."""
    channels, height, width = shape
    steps = weights.size - 1
    curves, total = new_tiled_streamlines(), scratch(np.float32, _SUMS)
    size = tile_capacity(steps, last - first, width, height)
    tangents, lattices = np.empty(size, np.complex64), np.empty(channels * size, np.complex64)
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            span = (x_end - x0 + LANES - 1) // LANES * LANES
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            if not fill_tangents(tangents, flow, around):
                return False
            for c in range(channels):
                fill_lattice(lattices[c * size :], planes, c * height * width, around)
            for y in range(y0, y_end):
                _start(curves, flow, x0, span, y, width)
                _start_sums(total, planes, weights[0], 0, channels, x0, span, y, height, width)
                for s in range(1, steps + 1):
                    if s > 1:
                        for k in range(0, 2 * span, LANES):
                            tx, ty = gather_pairs(tangents, curves.nearest, k)
                            turn(curves, k, tx, ty)
                    for k in range(0, 2 * span, LANES):
                        advance(curves, k, s, around, 1)
                    for c in range(channels):
                        for k in range(0, span, LANES):
                            a, b = _read(lattices[c * size :], curves, 2 * k)
                            _add(total, c * COLUMNS + k, a + b, weights[s])
                _finish_sums(total, blurred, 0, channels, x0, span, y, height, width)
    return True


@inlined
def _read(lattice: Any, curves: TiledStreamlines, k: int) -> tuple[Any, Any]:
    """At z of the walks both ways."""
    a = sample_lattice(
        lattice,
        curves.corner,
        k,
        fraction_beyond(load(curves.dx, k)),
        fraction_beyond(load(curves.dy, k)),
    )
    k += LANES
    return a, sample_lattice(
        lattice,
        curves.corner,
        k,
        fraction_beyond(load(curves.dx, k)),
        fraction_beyond(load(curves.dy, k)),
    )


@kernel
def _along_nearest(
    first: int, last: int, planes: Any, shape: PlanesShape, flow: Any, weights: Any, blurred: Any
) -> bool:
    """Two planes at a time: one load brings a tangent and two values. Whether all tangents were short enough."""
    channels, height, width = shape
    steps = weights.size - 1
    curves, total = new_tiled_streamlines(), scratch(np.float32, _SUMS)
    records = np.empty(2 * tile_capacity(steps, last - first, width, height), np.complex64)
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            span = (x_end - x0 + LANES - 1) // LANES * LANES
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            for c in range(0, channels, 2):
                c_end = min(c + 2, channels)
                pair = c * height * width, (c_end - 1) * height * width
                if not fill_records(records, flow, planes, pair, around):
                    return False
                for y in range(y0, y_end):
                    _start(curves, flow, x0, span, y, width)
                    _start_sums(total, planes, weights[0], c, c_end, x0, span, y, height, width)
                    for s in range(1, steps + 1):
                        for k in range(0, 2 * span, LANES):
                            advance(curves, k, s, around, 2)
                        for k in range(0, span, LANES):
                            a, b = _step_to(records, curves, 2 * k)
                            e, f = _step_to(records, curves, 2 * k + LANES)
                            _add(total, k, a + e, weights[s])
                            _add(total, COLUMNS + k, b + f, weights[s])
                    _finish_sums(total, blurred, c, c_end, x0, span, y, height, width)
    return True


@inlined
def _step_to(records: Any, curves: TiledStreamlines, k: int) -> tuple[Any, Any]:
    """Turn the walks to t(z); both values there."""
    tx, ty, a, b = gather_quads(records, curves.nearest, k)
    turn(curves, k, tx, ty)
    return a, b


@inlined
def _start(curves: TiledStreamlines, flow: Any, x0: int, span: int, y: int, width: int) -> None:
    """From ``span`` pixels of row y; the last sixteen overlap others where the picture ends."""
    for k in range(0, span, LANES):
        x = min(x0 + k, width - LANES)
        tx, ty = load_pairs(flow, y * width + x)
        start(curves, 2 * k, x, y, tx, ty)
        start(curves, 2 * k + LANES, x, y, -tx, -ty)


@inlined
def _start_sums(
    total: Any, planes: Any, weight: Any, c: int, c_end: int, x0: int, span: int, y: int, height: int, width: int
) -> None:
    """``total``: for each channel c .. c_end - 1 the weighted values of the centres."""
    for each in range(c, c_end):
        for k in range(0, span, LANES):
            x = min(x0 + k, width - LANES)
            store(total, (each - c) * COLUMNS + k, load(planes, (each * height + y) * width + x) * weight)


@inlined
def _add(total: Any, k: int, values: Any, weight: Any) -> None:
    store(total, k, load(total, k) + values * weight)


@inlined
def _finish_sums(
    total: Any, blurred: Any, c: int, c_end: int, x0: int, span: int, y: int, height: int, width: int
) -> None:
    for each in range(c, c_end):
        for k in range(0, span, LANES):
            x = min(x0 + k, width - LANES)
            store(blurred, (each * height + y) * width + x, load(total, (each - c) * COLUMNS + k))
