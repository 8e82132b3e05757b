"""Places on another frame that pixels' paths have come to, and what is read there, bilinearly.

A place is held as the pixel up and left of it and the distances from that one; its way there as the offset from the
path's own pixel, x right and y down. All of it stands in memory, a row at a time, so that reads need not wait for each
other.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.sampling.coords import Raster, padded_rows
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import (
    Floats,
    absolute,
    floor,
    lane_indices,
    maximum,
    minimum,
    select,
    splat_floats,
    to_ints,
)
from flowabs_nodes.simd.memory import address, gather_octets, gather_pairs, gather_quads, load, store

#: Pairs of floats, x then y: one complex64 for each pixel.
Pairs = npt.NDArray[np.complex64]

#: An offset beyond this, in pixels, leads out of any picture.
_FARTHEST = 2.0**22

Triple = tuple[Floats, Floats, Floats]

LOST = np.float32(np.nan)


class Path(NamedTuple):
    """Where the paths of some rows' pixels have come to on a frame, and what that is worth, each (rows x stride,)."""

    dx: Array  # the offset from the pixel; NaN where the path is lost
    dy: Array
    corner: npt.NDArray[np.int32]  # index in the picture of the pixel up and left of the place
    fx: Array  # the place's distance from that, 0 to 1
    fy: Array
    weight: Array


class Place(NamedTuple):
    """Sixteen places: their upper left pixels in memory, from ``at`` on, and the distances from them.

    What is read at places are :func:`~flowabs_nodes.simd.memory.address` of pictures.
    """

    corner: Any
    at: int
    fx: Floats
    fy: Floats
    below: int  # from a pixel to the one below it: 0 in a picture of one row


@inlined
def addresses(path: Path) -> Path:
    """Return the memory of paths, as the functions below take it."""
    dx, dy, corner, fx, fy, weight = path
    return Path(address(dx, 0), address(dy, 0), address(corner, 0), address(fx, 0), address(fy, 0), address(weight, 0))


@inlined
def set_place(path: Path, at: int, dx: Floats, dy: Floats, x: int, y: int, raster: Raster) -> None:
    """Let the paths of the pixels x .. x + 15 of row y come to the offsets (dx, dy); outside the picture they are lost.

    What is read at a lost place is the pixel's own surroundings; whoever asks looks at ``dx`` too.
    """
    near = (absolute(dx) < _FARTHEST) & (absolute(dy) < _FARTHEST)  # NaN is not
    dx, dy = select(near, dx, splat_floats(0.0)), select(near, dy, splat_floats(0.0))
    below_x, below_y = floor(dx), floor(dy)
    fx, fy = dx - below_x, dy - below_y
    left, top = to_ints(below_x) + (lane_indices() + x), to_ints(below_y) + y
    right, bottom = raster.width - 1, raster.height - 1
    inside = near & (left >= 0) & (top >= 0)
    inside = inside & ((left < right) | ((left == right) & (fx == 0.0)))
    inside = inside & ((top < bottom) | ((top == bottom) & (fy == 0.0)))
    # The last column and row are read as the end of the last step to them.
    fx = select(left < right, fx, splat_floats(1.0 if right > 0 else 0.0))
    fy = select(top < bottom, fy, splat_floats(1.0 if bottom > 0 else 0.0))
    left = maximum(minimum(left, right - 1), 0)
    top = maximum(minimum(top, bottom - 1), 0)
    store(path.dx, at, select(inside, dx, splat_floats(LOST)))
    store(path.dy, at, select(inside, dy, splat_floats(LOST)))
    store(path.corner, at, top * raster.stride + left)
    store(path.fx, at, fx)
    store(path.fy, at, fy)


@inlined
def place_of(path: Path, at: int, raster: Raster) -> Place:
    """Return the places of sixteen paths, from ``at`` on."""
    return Place(path.corner, at, load(path.fx, at), load(path.fy, at), raster.stride if raster.height > 1 else 0)


@inlined
def mix(a: Floats, b: Floats, share: Floats) -> Floats:
    """Return the linear interpolation from a, at share 0, to b, at share 1, exact at both."""
    return select(share < 1.0, a + share * (b - a), b)


@inlined
def mix4(a: Floats, b: Floats, c: Floats, d: Floats, at: Place) -> Floats:
    """Return the bilinear interpolation of the pixels up left, up right, down left and down right."""
    return mix(mix(a, b, at.fx), mix(c, d, at.fx), at.fy)


@inlined
def sample_plane(plane: Array, at: Place) -> Floats:
    """Return a plane (H x stride,) at the places."""
    a, b = gather_pairs(plane, at.corner, at.at)
    c, d = gather_pairs(address(plane, at.below), at.corner, at.at)
    return mix4(a, b, c, d, at)


@inlined
def corner_pairs(pairs: Pairs, at: Place) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats, Floats, Floats]:
    """Return x and y of a field of pairs at the pixels up left, up right, down left and down right of the places."""
    ax, ay, bx, by = gather_quads(pairs, at.corner, at.at)
    cx, cy, dx, dy = gather_quads(address(pairs, at.below), at.corner, at.at)
    return ax, ay, bx, by, cx, cy, dx, dy


def rows_of_triples(picture: Array, raster: Raster) -> Array:
    """Return a picture (H, W, 3) flattened, its rows padded, for :func:`corner_triples`.

    A row, or a column, that is alone has itself beside it.
    """
    rows = np.repeat(picture, raster.stride, axis=1) if raster.width == 1 else padded_rows(picture, raster)
    flat = rows.reshape(-1)
    return flat if raster.height > 1 else np.concatenate([flat, flat])


@inlined
def corner_triples(triples: Array, records: Int32, k: int, raster: Raster) -> tuple[Triple, Triple, Triple, Triple]:
    """Return the triples up left, up right, down left and down right of sixteen places.

    ``records`` holds, from k on, where those up left begin. Two neighbours are read as eight floats: in the upper row
    with the two after them, in the lower with the two before, which are all in the picture.
    """
    a, b, c, d, e, f, _, _ = gather_octets(triples, records, k)
    _, _, u, v, w, x, y, z = gather_octets(address(triples, 3 * raster.stride - 2), records, k)
    return (a, b, c), (d, e, f), (u, v, w), (x, y, z)
