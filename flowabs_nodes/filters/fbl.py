"""The flow-based bilateral filter (section 4.1): smooths along the flow, then across it, among similar colours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, inline, scratch, u
from flowabs_nodes.filters.exponential import LOG2_E, exp2
from flowabs_nodes.filters.gradient_line import line
from flowabs_nodes.filters.kernels import kernel, parallel_kernel
from flowabs_nodes.filters.sampling import SAMPLINGS, find, nearest, new_between, read, read_between
from flowabs_nodes.filters.walk import new_walk, start, step

TINY = np.float32(1e-20)  # an alpha from which colours can no longer be told


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
        Sigma of the Gaussian along and across the flow, in pixels, 0 to 10,000; 0 leaves that pass out.
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
    coverage = (
        np.broadcast_to(np.float32(1), codes.shape[:2])
        if alpha is None
        else arguments.plane("alpha", alpha, codes.shape)
    )

    # Pixels are (alpha L, alpha a, alpha b, alpha), so that bilinear readings mix colours by how much is there of each.
    picture, smoothed = np.empty((2, *codes.shape[:2], 4), np.float32)
    _multiply(codes, coverage, picture)
    for _ in range(iterations):
        for smooth, sigma, r in ((_along, sigma_e, r_e), (_across, sigma_g, r_g)):
            if sigma > 0:
                smooth(picture, flow, _closeness(sigma), _falloff(r), to_nearest, smoothed)
                picture, smoothed = smoothed, picture
    result = np.empty_like(codes)
    _divide(picture, codes, result)
    return result


def _closeness(sigma: float) -> Array:
    """log2 G(0), G(1) .. to one side, without the constant factor."""
    steps = np.arange(gaussian.radius(sigma) + 1)
    return (-LOG2_E / 2 * (steps / max(sigma, 1e-6)) ** 2).astype(np.float32)


def _falloff(r: float) -> np.float32:
    """log2 h for a colour difference of 1 (eq. 13), without the constant factor."""
    return np.float32(max(-LOG2_E / 2 / r / r, -1e30))


@parallel_kernel
def _multiply(codes: Any, alpha: Any, picture: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            a = alpha[y, x] if alpha[y, x] > TINY else np.float32(0.0)
            picture[y, x, 0] = a * codes[y, x, 0]
            picture[y, x, 1] = a * codes[y, x, 1]
            picture[y, x, 2] = a * codes[y, x, 2]
            picture[y, x, 3] = a


@parallel_kernel
def _divide(picture: Any, codes: Any, result: Any) -> None:
    height, width, _ = codes.shape
    for y in prange(height):
        for x in range(width):
            a = picture[y, x, 3]
            for c in range(3):
                result[y, x, c] = picture[y, x, c] / a if a > 0 else codes[y, x, c]


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
def _across(picture: Any, flow: Any, closeness: Any, falloff: Any, to_nearest: bool, smoothed: Any) -> None:
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


class Sums(NamedTuple):
    """Of each pixel of a block: its colour, the weighted sum of differences from it, and the sum of weights.

    Sums of differences round less than sums of colours would, and constants stay exactly as they are.
    """

    l: Any  # noqa: E741
    a: Any
    b: Any
    dl: Any
    da: Any
    db: Any
    weight: Any


@inline
def new_sums() -> Sums:
    return Sums(
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
        scratch(np.float32, 1),
    )


@inline
def begin(sums: Sums, picture: Any, block: Block) -> None:
    """The centre counts with its own alpha; its difference is 0."""
    first = u(4) * first_pixel(block)
    for i in range(block.size):
        k = first + u(4) * i
        alpha = picture[k + u(3)]
        over = np.float32(1.0) / alpha if alpha > 0 else np.float32(0.0)
        sums.l[i] = over * picture[k]
        sums.a[i] = over * picture[k + u(1)]
        sums.b[i] = over * picture[k + u(2)]
        sums.dl[i] = np.float32(0.0)
        sums.da[i] = np.float32(0.0)
        sums.db[i] = np.float32(0.0)
        sums.weight[i] = alpha


@inline
def weigh(sums: Sums, values: Any, closeness: Any, falloff: Any, block: Block) -> None:
    """Add one reading for each pixel, weighted by alpha G h."""
    for i in range(block.size):
        k = u(4) * i
        alpha = values[k + u(3)]
        over = np.float32(1.0) / alpha if alpha > TINY else np.float32(0.0)
        dl = over * values[k] - sums.l[i]
        da = over * values[k + u(1)] - sums.a[i]
        db = over * values[k + u(2)] - sums.b[i]
        weight = alpha * exp2(closeness + falloff * (dl * dl + da * da + db * db))
        sums.dl[i] += weight * dl
        sums.da[i] += weight * da
        sums.db[i] += weight * db
        sums.weight[i] += weight


@inline
def finish(sums: Sums, picture: Any, smoothed: Any, block: Block) -> None:
    first = u(4) * first_pixel(block)
    for i in range(block.size):
        k = first + u(4) * i
        alpha = picture[k + u(3)]
        over = np.float32(1.0) / sums.weight[i] if alpha > 0 else np.float32(0.0)
        smoothed[k] = alpha * (sums.l[i] + over * sums.dl[i])
        smoothed[k + u(1)] = alpha * (sums.a[i] + over * sums.da[i])
        smoothed[k + u(2)] = alpha * (sums.b[i] + over * sums.db[i])
        smoothed[k + u(3)] = alpha
