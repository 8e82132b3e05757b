"""Ink lines from passes anew, each kind with a pen of its own: width, colour, opacity.

``aov_lines`` says how far each pixel is from its nearest edge, d, positive on the near side, and draws one matte for
each kind of edge. From d a line of any width w follows, not only that of the matte: on the near side, of a crease on
both sides,

    ink = clamp(min(d, w - d) + 1/2, 0, min(w, 1)),    of a crease clamp(w / 2 - |d| + 1/2, 0, min(w, 1)),

the coverage of a pixel by the line. What kind of edge it is, the mattes say across it: with n = grad d / |grad d| the
foot of a pixel p is p - d n, and a kind is there as far as its matte M holds a pixel of ink,

    presence = min(1, sum over k of M(p - (d - k) n)),    k = -1/4, 3/4, 7/4; of a crease -1, 0, 1.

Samples a pixel apart of a line of width W add up to W, wherever between the pixels it lies.

Kinds are laid down in the order of ``PENS``, and their presences add up to 1 at most: each gets what the upper ones
leave. So where a line changes its kind, the parts of both make one line without a gap.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.background import BACKGROUND
from flowabs_nodes.filters.lines.stroke import stroke
from flowabs_nodes.filters.lines.stroke_widths import Block, ink_at
from flowabs_nodes.filters.passes.pens import PENS, WIDEST, Pen
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import exp2, log2
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import (
    LANES,
    Floats,
    absolute,
    any_lane,
    floor,
    lane_indices,
    maximum,
    minimum,
    select,
    splat_floats,
    splat_ints,
    sqrt,
    to_ints,
)
from flowabs_nodes.simd.memory import gather_pairs, load, scratch, store, store_quads

_KINDS = tuple(PENS)
_CREASE = _KINDS.index("crease")
_STEEPEST = np.float32(1.25)  # of a distance, a pixel further; what is steeper is a jump to another edge


class Pens(NamedTuple):
    """A kernel's view of the pens."""

    widths: Array  # (5,) pixels
    inks: Array  # (5, 4): colour times opacity, opacity
    widest: np.float32  # pixels from an edge up to which there may be ink
    by_depth: np.float32  # exponent of reference / depth
    reference: np.float32


def ink_lines(
    distance: npt.ArrayLike,
    mattes: Mapping[str, npt.ArrayLike],
    pens: Mapping[str, Pen] = PENS,
    flow: npt.ArrayLike | None = None,
    depth: npt.ArrayLike | None = None,
    width_by_depth: float = 0.0,
    reference_depth: float = 10.0,
    taper: float = 0.0,
) -> Array:
    """Return the ink of lines from passes, (H, W, 4) float32: red, green, blue, premultiplied, and its coverage A.

    Parameters
    ----------
    distance
        Pixels to the nearest edge, (H, W), positive on the near side, or to both sides of a crease; 10 far from any.
    mattes
        By its kind, "outline", "object", "material", "crease" or "intersection", (H, W): 1 in lines of this kind, at
        least a pixel wide. At least one.
    pens
        By kind; one that is left out draws as :data:`~flowabs_nodes.filters.passes.pens.PENS` says.
    flow
        (H, W, 2), unit tangents along the edges. Needed with ``taper``.
    depth
        Distance from the camera, (H, W), of which the nearest at the foot of a pixel counts. Needed with
        ``width_by_depth``. Where it is 1e9 or more, or no number, widths stay.
    width_by_depth
        0 to 2: widths are multiplied by (``reference_depth`` / depth)^``width_by_depth``; 1 is perspective. None
        becomes wider than 8 pixels.
    reference_depth
        The depth at which widths are those of the pens, above 0.
    taper
        Over how many pixels ends of lines thin out, 0 to 10,000 (:func:`~flowabs_nodes.filters.stroke`).

    Raises
    ------
    ArgumentError
        For another shape or dtype, a distance or matte that is not finite, a kind that does not exist, a parameter out
        of range, or one without the picture that it needs.
    """
    distance = validate.plane("distance", distance)
    found = _mattes(mattes, distance.shape)
    by_depth = validate.number("width_by_depth", width_by_depth, min=0, max=2)
    reference = validate.number("reference_depth", reference_depth, min=1e-6, max=1e9)
    taper = validate.number("taper", taper, min=0, max=10_000)
    for name, value, needed, given in (("width_by_depth", by_depth, "depth", depth), ("taper", taper, "flow", flow)):
        if value > 0 and given is None:
            raise ArgumentError(f"{name}: needs the {needed}", code="missing-input", parameter=needed)
    widths, inks = _of_pens(pens)
    widest = WIDEST if by_depth > 0 else float(widths.max())
    drawn = Pens(widths, inks, np.float32(widest), np.float32(by_depth), np.float32(reference))
    raster = raster_of(distance)
    rows = tuple(padded_rows(each, raster) if each.size else each.reshape(-1) for each in found)
    around = np.pad(distance, [(1, 1), (1, 1 + raster.stride - raster.width)], "edge").reshape(-1)
    behind = np.empty(0, np.float32)
    if by_depth > 0:
        assert depth is not None
        plane = validate.plane("depth", depth, distance.shape, check_finite=False)
        behind = np.pad(plane, [(0, 0), (0, 1 + raster.stride - raster.width)], "edge").reshape(-1)
    ink = np.empty((raster.height, raster.stride, 4), np.float32)
    over_rows(_ink, raster.height, around, rows, behind, drawn, raster, ink.reshape(-1))
    ink = np.ascontiguousarray(ink[:, : raster.width])
    return ink if taper == 0 else _tapered(ink, flow, taper)


def _mattes(mattes: Mapping[str, npt.ArrayLike], shape: tuple[int, ...]) -> list[Array]:
    """Return the matte of each kind, of no pixels where there is none, or no line in it."""
    _check_kinds("mattes", mattes)
    if not mattes:
        raise ArgumentError(
            f"expected at least one of {', '.join(_KINDS)}, found none", code="missing-input", parameter="mattes"
        )
    none = np.empty((0, 0), np.float32)
    found = {name: validate.plane(name, matte, shape) for name, matte in mattes.items()}
    return [found[name] if name in found and found[name].any() else none for name in _KINDS]


def _of_pens(pens: Mapping[str, Pen]) -> tuple[Array, Array]:
    """Return the widths of all kinds, (5,), and their inks, (5, 4)."""
    _check_kinds("pens", pens)
    widths, inks = [], []
    for name in _KINDS:
        width, color, opacity = pens.get(name, PENS[name])
        if len(color) != 3:
            raise ArgumentError(f"{name}_color: expected three numbers, found {len(color)}", parameter=f"{name}_color")
        widths.append(validate.number(f"{name}_width", width, min=0, max=WIDEST))
        covering = validate.number(f"{name}_opacity", opacity, min=0, max=1)
        inks.append([covering * validate.number(f"{name}_color", part) for part in color] + [covering])
    return np.array(widths, np.float32), np.array(inks, np.float32)


def _check_kinds(argument: str, given: Mapping[str, object]) -> None:
    """Raise ArgumentError where a key is no kind of line."""
    for name in given:
        if name not in _KINDS:
            message = f"{argument}: there is no kind {name!r}"
            raise ArgumentError(message, hint=nearest(name, _KINDS), parameter=argument)


def _tapered(ink: Array, flow: npt.ArrayLike | None, taper: float) -> Array:
    """Return ink whose lines thin out towards their ends."""
    assert flow is not None  # the caller has looked
    lines = 1 - ink[..., 3]
    covered, left = 1 - lines, 1 - stroke(lines, flow, taper=taper)
    share = np.divide(left, covered, out=np.zeros_like(left), where=covered > 0)
    return np.asarray(ink * share[..., np.newaxis], np.float32)


@kernel
def _ink(
    first: int,
    last: int,
    distance: Array,
    mattes: tuple[Array, Array, Array, Array, Array],
    depth: Array,
    pens: Pens,
    raster: Raster,
    ink: Array,
) -> None:
    """Draw the rows ``first`` .. ``last`` - 1 of ``ink``, (H, stride, 4) flattened.

    ``distance`` has its border repeated once to each side, ``depth`` once to the right.
    """
    place = scratch(np.int32, 1)
    wide = raster.stride + 2
    for y in range(first, last):
        for x0 in range(0, raster.stride, LANES):
            x = min(x0, raster.stride - LANES)
            at, i = (y + 1) * wide + x + 1, y * raster.stride + x
            d = load(distance, at)
            red, green, blue, alpha = splat_floats(0.0), splat_floats(0.0), splat_floats(0.0), splat_floats(0.0)
            if any_lane((d > -0.5) & (d < pens.widest + 0.5)):
                nx = _slope(load(distance, at - 1), d, load(distance, at + 1))
                ny = _slope(load(distance, at - wide), d, load(distance, at + wide))
                steep = nx * nx + ny * ny
                inverse = select(steep > 0.0, 1.0 / sqrt(steep), 0.0)
                nx, ny = nx * inverse, ny * inverse
                block = Block(lane_indices() + x, splat_ints(y))
                wider = splat_floats(1.0)
                if depth.size > 0:
                    wider = _by_depth(depth, block, d, nx, ny, pens, raster, place)
                rest = splat_floats(1.0)
                for kind in range(5):
                    if mattes[kind].size == 0 or pens.widths[kind] == 0:
                        continue
                    w = minimum(pens.widths[kind] * wider, WIDEST)
                    if kind == _CREASE:
                        line = select(d > -0.5, w * 0.5 - absolute(d) + 0.5, 0.0)
                        nearest = -1.0
                    else:
                        line = minimum(d, w - d) + 0.5
                        nearest = -0.25
                    line = maximum(minimum(line, minimum(w, 1.0)), 0.0)
                    if any_lane(line > 0.0):
                        held = splat_floats(0.0)
                        for step in range(3):
                            away = nearest + np.float32(step) - d
                            held = held + ink_at(mattes[kind], block, away * nx, away * ny, raster, place)
                        presence = select(line > 0.0, minimum(maximum(held, 0.0), rest), 0.0)
                        rest = rest - presence
                        part = presence * line
                        red, green = red + part * pens.inks[kind, 0], green + part * pens.inks[kind, 1]
                        blue, alpha = blue + part * pens.inks[kind, 2], alpha + part * pens.inks[kind, 3]
            store_quads(ink, 4 * i, (red, green, blue, alpha))


@inlined
def _slope(before: Floats, here: Floats, after: Floats) -> Floats:
    """Return the slope of a distance along one axis: the mean of both sides, but for one where it jumps."""
    a, b = here - before, after - here
    flat_a, flat_b = absolute(a) < _STEEPEST, absolute(b) < _STEEPEST
    sides = select(flat_a, splat_floats(1.0), 0.0) + select(flat_b, splat_floats(1.0), 0.0)
    return (select(flat_a, a, 0.0) + select(flat_b, b, 0.0)) / maximum(sides, 1.0)


@inlined
def _by_depth(
    depth: Array, block: Block, d: Floats, nx: Floats, ny: Floats, pens: Pens, raster: Raster, place: Int32
) -> Floats:
    """Return what widths are multiplied by: the nearest of three depths across the foot of each pixel says it."""
    z = splat_floats(np.inf)
    for step in range(3):
        away = np.float32(step) - 0.25 - d
        x = minimum(maximum(to_ints(floor(away * nx + 0.5)) + block.x, 0), raster.width - 1)
        y = minimum(maximum(to_ints(floor(away * ny + 0.5)) + block.y, 0), raster.height - 1)
        store(place, 0, y * (raster.stride + 1) + x)
        there, _ = gather_pairs(depth, place, 0)
        z = select(there < z, there, z)
    scale = exp2(pens.by_depth * log2(pens.reference / minimum(maximum(z, 1e-6), BACKGROUND)))
    return select(z < BACKGROUND, scale, 1.0)
