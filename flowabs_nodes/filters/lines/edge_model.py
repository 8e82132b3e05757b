"""The edge model: which Gaussian-blurred edge a pixel belongs to, and what a line filter would answer were it sharp.

Along the gradient axis l_x of a picture that was blurred by t, a step of contrast C at p0, itself blurred by b, has the
gradient

    g(p) = C G(p - p0; b_t),  b_t^2 = b^2 + t^2  (G the normal density),

whose logarithm is a parabola. Three gradients, at p = -d, 0, d of the pixel, so tell all there is to know, for any d:
with l-, l0, l+ = ln g and q = l- + l+ - 2 l0,

    b_t^2 = -d^2 / q,  x = -p0 = (d / 2) (l+ - l-) / q,  C = g(0) sqrt(2 pi) b_t exp(x^2 / 2 b_t^2).

(Scale and place of an edge from derivatives of a blurred picture: Elder and Zucker, "Local scale control for edge
detection and blur estimation", 1998.) To such an edge f (eq. 8) answers, but for a constant, C h(x, b^2), with

    h(x, v) = Phi(x / sqrt(v + sigma_c^2)) - rho Phi(x / sqrt(v + sigma_s^2)),  Phi the normal distribution.

So C (h(x, wanted) - h(x, b^2)) is what it lacks. Since a line is drawn from the sum, a soft edge gets the line of a
sharp one: of its width, in its place.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.lines.dog_line import locate_both_sides
from flowabs_nodes.sampling.tile_cache import (
    COLUMNS,
    ROWS,
    PlanesShape,
    fill_lattice,
    sample_lattice,
    tile_around,
    tile_capacity,
)
from flowabs_nodes.simd.elementary import LOG2_E, erf, exp2, log2
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, absolute, maximum, minimum, select, splat_floats, sqrt
from flowabs_nodes.simd.memory import load, load_pairs, scratch, store

# An edge counts between the first and the second of these fully, or no longer. All were chosen on photographs.
#: b_t^2 / t^2, which is 1 or more at edges, 1/2 at thin lines and 1/3 in white noise.
_FINER, _NOT_FINER = 0.8, 0.95
#: b / t: edges softer than that are shading.
_SOFT, _TOO_SOFT = 2.0, 20 / 7
#: t^3 C / (sqrt(2 pi) max(b_t, t)^3) in code values: the third derivative at the edge, times t^3. The smaller it is,
#: the farther noise moves an edge: white noise of sigma 2 by 0.4 and 0.2 pixels, 2 sqrt(3 / 16 pi) over it.
_UNSURE, _SURE = 1.3, 2.1
#: How far the gradients at -e and e are from those of the edge, in units of its own: others are near, as at thin lines.
_ALONE, _CROWDED = 0.3, 0.6
#: Curvature of the edge times b_t: rings and blobs that are hardly larger than their blur have no outline.
_STRAIGHT, _BENT = 0.2, 0.4

_HALF = 0.5  # pixels to either side, between which a gradient is measured
_SAMPLING = 0.25  # square pixels that this (1/12) and bilinear samples (1/6 in the mean) add to the variance of an edge
_FLAT = 1e-6  # squared gradient in code values below which there is no edge
_ENORMOUS = 1e30  # and above which none is looked for, so that all stays within float32
_LEAST = 0.01  # squared gradients are at least this times that of the pixel; at other edges they may be below 0
_LEAST_Q = 1e-3  # -q at least: below, the gradient does not fall from here
_FARTHEST = 2.0  # x^2 / 2 b_t^2 at most, when C is told from g(0)
_ROOT_OF_TWO_PI = 2.5066282746310002


class EdgeModel(NamedTuple):
    """What edges are measured by, and what is to be added: float32 all of them."""

    t: np.float32  # sigma of the blur that the picture has got, in pixels
    d: np.float32  # distances of the gradients, in pixels
    e: np.float32
    color_weight: np.float32  # of the second and third channel, as in the response
    amount: np.float32  # how much of what is missing is added, 0 to 1
    rho: np.float32
    inner: np.float32  # sigma_c^2
    outer: np.float32  # sigma_s^2
    seen: np.float32  # variance, in square pixels, of the blur that the line filter's picture gets
    wanted: np.float32  # and of the blur that its edges shall seem to have


class Gradients(NamedTuple):
    """Products of the gradient at a pixel with gradients around it, summed over channels by their weights."""

    here: Floats  # with itself
    after: Floats  # at d
    before: Floats  # at -d
    beyond: Floats  # at e
    behind: Floats  # at -e
    turn: Floats  # with the second derivative along the tangent


class Edge(NamedTuple):
    """The edge that sixteen pixels belong to."""

    m: Floats  # g(0)^2
    x: Floats  # where the pixel is, seen from the edge
    variance: Floats  # b_t^2
    b_t: Floats
    blur_variance: Floats  # b^2
    lift: Floats  # g(p0) / g(0)


@kernel
def missing_response(
    first: int,
    last: int,
    planes: Array,
    shape: PlanesShape,
    flow: npt.NDArray[np.complex64],
    model: EdgeModel,
    missing: Array,
) -> None:
    """Write rows ``first`` .. ``last`` - 1 of what the sums across the flow (eq. 10) lack since edges are blurred.

    ``planes`` and ``missing`` are (C, H, W) float32, ``flow`` (H, W) complex64, all flattened; W is at least sixteen.
    Of tangents only the direction counts.
    """
    channels, height, width = shape
    steps = int(np.ceil(model.e + _HALF))
    distances = (_HALF, model.d - _HALF, model.d + _HALF, model.e - _HALF, model.e + _HALF)
    entries, offsets, gradient = scratch(np.int32, 12), scratch(np.float32, 12), scratch(np.float32, 4)
    size = tile_capacity(steps, last - first, width, height)
    lattices = np.empty(channels * size, np.complex64)
    for y0 in range(first, last, ROWS):
        for x0 in range(0, width, COLUMNS):
            y_end, x_end = min(y0 + ROWS, last), min(x0 + COLUMNS, width)
            around = tile_around(x0, y0, x_end, y_end, steps, width, height)
            for c in range(channels):
                fill_lattice(lattices[c * size :], planes, c * height * width, around)
            for y in range(y0, y_end):
                for each in range(x0, x_end, LANES):
                    x = min(each, width - LANES)
                    tx, ty = direction(flow, y * width + x)
                    for k, far in enumerate(distances):
                        locate_both_sides(ty * far, -tx * far, x, y, around, entries, offsets, k)
                    locate_both_sides(tx * model.t, ty * model.t, x, y, around, entries, offsets, 5)
                    none = splat_floats(0.0)
                    sums = Gradients(none, none, none, none, none, none)
                    for c in range(channels):
                        value = load(planes, (c * height + y) * width + x)
                        weight = model.color_weight * model.color_weight if c > 0 else np.float32(1.0)
                        lattice = lattices[c * size :]
                        g, sums = _add_channel(sums, lattice, entries, offsets, value, weight, model.t)
                        store(gradient, LANES * c, g)
                    share = _missing_share(sums, model)
                    for c in range(channels):
                        store(missing, (c * height + y) * width + x, load(gradient, LANES * c) * share)


@inlined
def direction(flow: npt.NDArray[np.complex64], pixel: int) -> tuple[Floats, Floats]:
    """Return the tangents of sixteen pixels, of length 1, or 0 where there is none."""
    tx, ty = load_pairs(flow, pixel)
    longest = maximum(maximum(absolute(tx), absolute(ty)), 1e-30)
    tx, ty = tx / longest, ty / longest  # whose squares neither vanish nor leave float32
    length = sqrt(maximum(tx * tx + ty * ty, 0.25))
    return tx / length, ty / length


@inlined
def _add_channel(
    sums: Gradients,
    lattice: npt.NDArray[np.complex64],
    entries: Int32,
    offsets: Array,
    value: Floats,
    weight: float,
    t: float,
) -> tuple[Floats, Gradients]:
    """Return the gradient of a channel at sixteen pixels, which have the values ``value``, and the sums with it."""
    right, left = _both_sides(lattice, entries, offsets, 0)
    near_d, near_minus_d = _both_sides(lattice, entries, offsets, 1)
    past_d, past_minus_d = _both_sides(lattice, entries, offsets, 2)
    near_e, near_minus_e = _both_sides(lattice, entries, offsets, 3)
    past_e, past_minus_e = _both_sides(lattice, entries, offsets, 4)
    ahead, back = _both_sides(lattice, entries, offsets, 5)
    g = right - left
    counts = g * weight
    return g, Gradients(
        sums.here + counts * g,
        sums.after + counts * (past_d - near_d),
        sums.before + counts * (near_minus_d - past_minus_d),
        sums.beyond + counts * (past_e - near_e),
        sums.behind + counts * (near_minus_e - past_minus_e),
        sums.turn + counts * ((ahead - value) + (back - value)) * (1.0 / (t * t)),
    )


@inlined
def _both_sides(lattice: npt.NDArray[np.complex64], entries: Int32, offsets: Array, k: int) -> tuple[Floats, Floats]:
    """Return the samples at the k-th points, one to either side."""
    u, v = load(offsets, 2 * LANES * k), load(offsets, 2 * LANES * k + LANES)
    other = sample_lattice(lattice, entries, 2 * LANES * k + LANES, 1.0 - u, 1.0 - v)
    return sample_lattice(lattice, entries, 2 * LANES * k, u, v), other


@inlined
def _missing_share(sums: Gradients, model: EdgeModel) -> Floats:
    """Return what a channel's response lacks, divided by its gradient g(0)."""
    edge = _edge(sums, model)
    contrast = edge.b_t * edge.lift * _ROOT_OF_TWO_PI  # C / g(0)
    present = edge.blur_variance + model.seen
    lacks = contrast * (_h(edge.x, minimum(present, model.wanted), model) - _h(edge.x, present, model))
    return lacks * _certainty(edge, sums, model) * model.amount


@inlined
def _edge(sums: Gradients, model: EdgeModel) -> Edge:
    """Return the edge that has the gradients of ``sums``."""
    m = minimum(maximum(sums.here, _FLAT), _ENORMOUS)
    l0 = log2(m)
    after = log2(minimum(maximum(sums.after, _LEAST * m), _ENORMOUS)) - l0
    before = log2(minimum(maximum(sums.before, _LEAST * m), _ENORMOUS)) - l0
    q = minimum((after + before) / LOG2_E, -_LEAST_Q)
    variance = model.d * model.d / -q
    x = model.d * (0.5 / LOG2_E) * (after - before) / q
    lift = exp2(minimum(x * x / (2.0 * variance), _FARTHEST) * LOG2_E)
    blur_variance = maximum(variance - _SAMPLING - model.t * model.t, 0.0)
    return Edge(m, x, variance, sqrt(variance), blur_variance, lift)


@inlined
def _certainty(edge: Edge, sums: Gradients, model: EdgeModel) -> Floats:
    """Return how far the edge that was found is one, and worth a line: 0 to 1."""
    t = model.t
    finer = _rise((edge.variance - _SAMPLING) / (t * t), _FINER, _NOT_FINER)
    soft = 1.0 - _rise(sqrt(edge.blur_variance) / t, _SOFT, _TOO_SOFT)
    wide = t / maximum(edge.b_t, t)
    sure = _rise(sqrt(edge.m) * edge.lift * edge.b_t * wide * wide * wide, _UNSURE, _SURE)
    off = maximum(_unlike(edge, model.e, sums.beyond), _unlike(edge, -model.e, sums.behind))
    alone = 1.0 - _rise(off / edge.lift, _ALONE, _CROWDED)
    straight = 1.0 - _rise(absolute(sums.turn) / edge.m * edge.b_t, _STRAIGHT, _BENT)
    there = select(sums.here > _FLAT, select(sums.here < _ENORMOUS, splat_floats(1.0), 0.0), 0.0)
    return there * finer * soft * sure * alone * straight


@inlined
def _unlike(edge: Edge, far: float, product: Floats) -> Floats:
    """Return how far the gradient at ``far`` is from what the edge makes it there, in units of g(0).

    ``product`` is that of the two gradients.
    """
    exponent = (edge.x * edge.x - (edge.x + far) * (edge.x + far)) / (2.0 * edge.variance) * LOG2_E
    return absolute(product / edge.m - exp2(minimum(maximum(exponent, -100.0), 100.0)))


@inlined
def _h(x: Floats, variance: Floats, model: EdgeModel) -> Floats:
    """Return h(x, variance), but for a constant: Phi(z) is 1/2 + erf(z / sqrt 2) / 2."""
    inner = erf(x / sqrt(2.0 * (variance + model.inner)))
    outer = erf(x / sqrt(2.0 * (variance + model.outer)))
    return 0.5 * (inner - model.rho * outer)


@inlined
def _rise(x: Floats, low: float, high: float) -> Floats:
    """Return smoothstep(low, high, x): 0 up to ``low``, 1 from ``high`` on."""
    x = minimum(maximum((x - low) / (high - low), 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)
