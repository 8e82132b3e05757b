"""Gaussian blur along the streamlines c_x of a flow: eq. 11 for any picture."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.sampling.exact_sums import exact_sum
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
    Tile,
    count_busy,
    fill_lattice,
    fill_records,
    fill_tangents,
    over_tiles,
    reach,
    sample_lattice,
    tile_around,
    tile_capacity,
)
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, splat_floats
from flowabs_nodes.simd.memory import gather_pairs, gather_quads, load, load_pairs, scratch, store

_SUMS = 4 * BLOCKS  # vectors of sums: a row of a tile, four channels

Pairs = npt.NDArray[np.complex64]  # pairs of floats


class Row(NamedTuple):
    """The pixels of a tile's row: ``span`` columns from x0 on, a multiple of sixteen, of row y of a picture.

    Where the picture ends, the last sixteen overlap those before.
    """

    x0: int
    span: int
    y: int
    height: int  # of the picture
    width: int


def flow_blur(image: npt.ArrayLike, flow: npt.ArrayLike, sigma: float = 2.0, sampling: str = "bilinear") -> Array:
    """Blur each channel along the flow: a Gaussian-weighted mean over every pixel's streamline.

    Parameters
    ----------
    image
        (H, W) or (H, W, C) with up to four channels, any scale; RGBA premultiplied.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma
        Standard deviation in pixels along the streamline, 0 to 10,000; 0 gives a copy. Cut at ceil(3 sigma).
    sampling
        How the image is read along the streamline: "bilinear" or "nearest" pixel.

    Returns
    -------
    The blurred image, float32, of the same shape.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    image = validate.any_channels("image", image, summed=True)
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
    """Return an image of (H, W) or (H, W, C) as C-contiguous planes, (C, H, W)."""
    if image.ndim == 2:
        return np.ascontiguousarray(image[None])
    planes = np.empty((image.shape[2], *image.shape[:2]), image.dtype)

    def band(first: int, last: int) -> None:
        """Lay out the rows ``first`` .. ``last`` - 1."""
        planes[:, first:last] = np.moveaxis(image[first:last], -1, 0)

    over_rows(band, len(image))
    return planes


def along(
    planes: Array, flow: Array, weights: npt.NDArray[np.float64], sampling: str, ground: float | None = None
) -> Array:
    """Return the weighted sum of up to four planes over the streamline c_x of each pixel (eq. 11), (C, H, W) float32.

    Parameters
    ----------
    planes
        (C, H, W) float32.
    flow
        (H, W, 2) float32. Tangents that are too long for tiles take a slower path.
    weights
        Weights of the steps 0, 1 .. to either side: G(sigma_m) in eq. 11.
    sampling
        "bilinear" or "nearest".
    ground
        What much of a picture of one plane is, if anything, as paper is of lines. Where all around is, nothing is read
        to find that it stays so. It changes no bit.
    """
    if sampling == "nearest":
        blurred = over_tiles(_along_nearest, planes, flow, weights)
    else:
        no_ground = ground is None or len(planes) > 1
        blurred = over_tiles(_along_bilinear, planes, flow, weights, np.float32(np.nan if no_ground else ground))
    return exact_sum(planes, flow, np.ones(1), weights, sampling) if blurred is None else blurred


@kernel
def _along_bilinear(
    first: int,
    last: int,
    planes: Array,
    shape: PlanesShape,
    flow: Pairs,
    weights: Array,
    ground: float,
    blurred: Array,
) -> bool:
    """Write eq. 11, read bilinearly, for the rows ``first`` .. ``last`` - 1.

    ``planes`` and ``blurred`` are (C, H, W) flattened, ``flow`` one pair per pixel; W is at least sixteen. ``ground``
    is NaN, or what much of a single plane is: then a row of a tile is worked on from the first block to the last that
    reaches anything else. Returns False, with rows not written, if a tangent is too long for tiles.
    """
    channels, height, width = shape
    steps = weights.size - 1
    curves, total = new_tiled_streamlines(), scratch(np.float32, _SUMS)
    size = tile_capacity(steps, last - first, width, height)
    tangents, lattices = np.empty(size, np.complex64), np.empty(channels * size, np.complex64)
    far, grounded, still = reach(steps), ground == ground, scratch(np.float32, 1)
    busy = np.empty((ROWS + 2 * far + 4, BLOCKS), np.int32)
    store(still, 0, splat_floats(ground) * weights[0])  # what the ground's sum comes to, with its rounding
    for s in range(1, steps + 1):
        if weights[s] != 0:
            _add(still, 0, splat_floats(ground) + ground, weights[s])
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            across = (x_end - x0 + LANES - 1) // LANES * LANES
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            if not fill_tangents(tangents, flow, around):
                return False
            for c in range(channels):
                fill_lattice(lattices[c * size :], planes, c * height * width, around)
            if grounded:
                count_busy(busy, planes, ground, x0, x_end, far, around)
            for y in range(y0, y_end):
                row = Row(x0, across, y, height, width)
                if grounded:
                    for k in range(0, across, LANES):
                        store(blurred, y * width + min(x0 + k, width - LANES), load(still, 0))
                    row = _busy_part(busy, row, far, around)
                span = row.span
                _start(curves, flow, row)
                _start_sums(total, planes, weights[0], 0, channels, row)
                for s in range(1, steps + 1):
                    if s > 1:
                        for k in range(0, 2 * span, LANES):
                            tx, ty = gather_pairs(tangents, curves.nearest, k)
                            turn(curves, k, tx, ty)
                    for k in range(0, 2 * span, LANES):
                        advance(curves, k, s, around, 1)
                    if weights[s] == 0:
                        continue
                    for c in range(channels):
                        for k in range(0, span, LANES):
                            one_way = _read(lattices[c * size :], curves, 2 * k)
                            other_way = _read(lattices[c * size :], curves, 2 * k + LANES)
                            _add(total, c * COLUMNS + k, one_way + other_way, weights[s])
                _finish_sums(total, blurred, 0, channels, row)
    return True


@inlined
def _busy_part(busy: Int32, row: Row, far: int, tile: Tile) -> Row:
    """Return the part of a tile's row from the first to the last block with anything but ground up to ``far`` away."""
    top, end = max(row.y - far, tile.top) - tile.top, min(row.y + far, tile.bottom + 1) + 1 - tile.top
    first, last = row.span // LANES, 0
    for block in range(row.span // LANES):
        if busy[end, block] > busy[top, block]:
            first, last = min(first, block), block + 1
    return Row(row.x0 + first * LANES, max(last - first, 0) * LANES, row.y, row.height, row.width)


@inlined
def _read(lattice: Pairs, curves: TiledStreamlines, k: int) -> Any:
    """Return a plane's values at the points z that sixteen streamlines, ``curves`` from k on, have come to."""
    u, v = fraction_beyond(load(curves.dx, k)), fraction_beyond(load(curves.dy, k))
    return sample_lattice(lattice, curves.corner, k, u, v)


@kernel
def _along_nearest(
    first: int, last: int, planes: Array, shape: PlanesShape, flow: Pairs, weights: Array, blurred: Array
) -> bool:
    """Write eq. 11, read at the nearest pixels, as :func:`_along_bilinear` does.

    Two planes are summed at a time: one load brings a tangent and two values.
    """
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
                    row = Row(x0, span, y, height, width)
                    _start(curves, flow, row)
                    _start_sums(total, planes, weights[0], c, c_end, row)
                    for s in range(1, steps + 1):
                        for k in range(0, 2 * span, LANES):
                            advance(curves, k, s, around, 2)
                        for k in range(0, span, LANES):
                            a, b = _read_and_turn(records, curves, 2 * k)
                            e, f = _read_and_turn(records, curves, 2 * k + LANES)
                            _add(total, k, a + e, weights[s])
                            _add(total, COLUMNS + k, b + f, weights[s])
                    _finish_sums(total, blurred, c, c_end, row)
    return True


@inlined
def _read_and_turn(records: Pairs, curves: TiledStreamlines, k: int) -> tuple[Any, Any]:
    """Return two planes' values at z for sixteen streamlines, ``curves`` from k on, and turn these to go along t(z)."""
    tx, ty, a, b = gather_quads(records, curves.nearest, k)
    turn(curves, k, tx, ty)
    return a, b


@inlined
def _start(curves: TiledStreamlines, flow: Pairs, row: Row) -> None:
    """Start the streamlines of a row's pixels: of each sixteen, along their tangents, then against them."""
    for k in range(0, row.span, LANES):
        x = min(row.x0 + k, row.width - LANES)
        tx, ty = load_pairs(flow, row.y * row.width + x)
        start(curves, 2 * k, x, row.y, tx, ty)
        start(curves, 2 * k + LANES, x, row.y, -tx, -ty)


@inlined
def _start_sums(total: Any, planes: Array, weight: Any, c: int, c_end: int, row: Row) -> None:
    """Write the weighted values of a row's pixels themselves into ``total``, for the channels c .. c_end - 1."""
    for each in range(c, c_end):
        for k in range(0, row.span, LANES):
            x = min(row.x0 + k, row.width - LANES)
            value = load(planes, (each * row.height + row.y) * row.width + x)
            store(total, (each - c) * COLUMNS + k, value * weight)


@inlined
def _add(total: Any, k: int, values: Any, weight: Any) -> None:
    """Add sixteen weighted values to ``total`` from k on."""
    store(total, k, load(total, k) + values * weight)  # eq. 11


@inlined
def _finish_sums(total: Any, blurred: Array, c: int, c_end: int, row: Row) -> None:
    """Write the sums of the channels c .. c_end - 1 into a row of the result."""
    for each in range(c, c_end):
        for k in range(0, row.span, LANES):
            x = min(row.x0 + k, row.width - LANES)
            store(blurred, (each * row.height + row.y) * row.width + x, load(total, (each - c) * COLUMNS + k))
