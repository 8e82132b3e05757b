"""The flow-based bilateral filter (section 4.1): smooths along the flow, then across it, among similar colours."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, scratch, u
from flowabs_nodes.filters.gradient_line import line
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.moves import follow, stay, written_walks
from flowabs_nodes.filters.sampling import SAMPLINGS, find, nearest, new_between, read, read_between
from flowabs_nodes.filters.similarity import begin, closeness, coverage, falloff, finish, in_turn, new_sums, weigh
from flowabs_nodes.filters.walk import new_walk, start, step


def fbl(
    codes: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_e: float = 2.0,
    r_e: float = 10.0,
    sigma_g: float = 0.5,
    r_g: float = 10.0,
    iterations: int = 5,
    sampling: str = "nearest",
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Flow-based bilateral filter, eqs. 12-14: C_e along the flow, then C_g across it, ``iterations`` times.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha. Colours differ by their Euclidean distance.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma_e, sigma_g
        Sigma of the Gaussian along and across the flow, in pixels, 0 to 10,000; 0 leaves that pass out. With several
        iterations and nearest pixels, up to ``sigma_e`` 5.3, the walks take 2 ceil(3 ``sigma_e``) bytes a pixel.
    r_e, r_g
        Sigma of the Gaussian of colour differences along and across the flow, in code values, above 0 (eq. 13).
    iterations
        At least 0; 0 gives a copy.
    sampling
        How curve and gradient line are read, "nearest" pixel (crisper, faster) or "bilinear".
    alpha
        (H, W), coverage: every reading's weight is multiplied by its alpha, so that the colour of what is not there
        never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.

    Returns
    -------
    The smoothed code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = arguments.planes("codes", codes)
    flow = arguments.flow_field(flow, codes.shape)
    sigma_e = arguments.number("sigma_e", sigma_e, min=0, max=10_000)
    r_e = arguments.number("r_e", r_e, above=0)
    sigma_g = arguments.number("sigma_g", sigma_g, min=0, max=10_000)
    r_g = arguments.number("r_g", r_g, above=0)
    iterations = arguments.whole("iterations", iterations, min=0)
    to_nearest = arguments.choice("sampling", sampling, SAMPLINGS) == "nearest"
    passes: list[Callable[[Array, Array], None]] = []
    if sigma_e > 0:
        near, like = closeness(sigma_e), falloff(r_e)
        moves = written_walks(flow, near.size - 1) if to_nearest and iterations > 1 else None
        if moves is None:
            passes.append(lambda picture, out: _along(picture, flow, near, like, to_nearest, out))
        else:
            passes.append(lambda picture, out: _along_moves(picture, moves, near, like, out))
    if sigma_g > 0:
        passes.append(lambda picture, out: across(picture, flow, closeness(sigma_g), falloff(r_g), to_nearest, out))
    return in_turn(codes, coverage(alpha, codes), passes, iterations)


@parallel_kernel
def _along(picture: Any, flow: Any, closeness: Any, falloff: Any, to_nearest: bool, smoothed: Any) -> None:
    """C_e, eq. 12."""
    height, width, _ = picture.shape
    source, tangents, target = picture.reshape(-1), flow.reshape(-1), smoothed.reshape(-1)
    for y in prange(height):
        _along_row(source, tangents, closeness, falloff, to_nearest, np.int64(y), width, height, target)


@kernel
def _along_row(
    picture: Any,
    flow: Any,
    closeness: Any,
    falloff: Any,
    to_nearest: bool,
    y: int,
    width: int,
    height: int,
    smoothed: Any,
) -> None:
    walk, between, values, sums = new_walk(), new_between(), scratch(np.float32, 4), new_sums()
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        begin(sums, picture, block)
        for way in range(2):
            start(walk, flow, way, block)
            for s in range(1, closeness.size):
                step(walk, flow, block)
                if to_nearest:
                    read(picture, walk.pixel, values, block)
                else:
                    find(walk.dx, walk.dy, between, block)
                    read_between(picture, between, values, block)
                weigh(sums, values, closeness[u(s)], falloff, block)
        finish(sums, picture, smoothed, block)


@parallel_kernel
def _along_moves(picture: Any, moves: Any, closeness: Any, falloff: Any, smoothed: Any) -> None:
    """C_e, eq. 12, along walks that are written down."""
    height, width, _ = picture.shape
    source, target = picture.reshape(-1), smoothed.reshape(-1)
    for y in prange(height):
        _along_moves_row(source, moves[y], closeness, falloff, np.int64(y), width, height, target)


@kernel
def _along_moves_row(
    picture: Any, moves: Any, closeness: Any, falloff: Any, y: int, width: int, height: int, smoothed: Any
) -> None:
    pixel, values, sums = scratch(np.int32, 1), scratch(np.float32, 4), new_sums()
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        begin(sums, picture, block)
        for way in range(2):
            stay(pixel, block)
            for s in range(1, closeness.size):
                follow(moves[u(way), u(s - 1)], pixel, block)
                read(picture, pixel, values, block)
                weigh(sums, values, closeness[u(s)], falloff, block)
        finish(sums, picture, smoothed, block)


@parallel_kernel
def across(picture: Any, flow: Any, closeness: Any, falloff: Any, to_nearest: bool, smoothed: Any) -> None:
    """C_g, eq. 14."""
    height, width, _ = picture.shape
    source, tangents, target = picture.reshape(-1), flow.reshape(-1), smoothed.reshape(-1)
    for y in prange(height):
        _across_row(source, tangents, closeness, falloff, to_nearest, np.int64(y), width, height, target)


@kernel
def _across_row(
    picture: Any,
    flow: Any,
    closeness: Any,
    falloff: Any,
    to_nearest: bool,
    y: int,
    width: int,
    height: int,
    smoothed: Any,
) -> None:
    dx, dy = scratch(np.float64, 1), scratch(np.float64, 1)
    between, values, sums = new_between(), scratch(np.float32, 4), new_sums()
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        begin(sums, picture, block)
        for side in range(2):
            for n in range(1, closeness.size):
                line(flow, n if side == 0 else -n, dx, dy, block)
                if to_nearest:
                    nearest(dx, dy, between.pixel, block)
                    read(picture, between.pixel, values, block)
                else:
                    find(dx, dy, between, block)
                    read_between(picture, between, values, block)
                weigh(sums, values, closeness[u(n)], falloff, block)
        finish(sums, picture, smoothed, block)
