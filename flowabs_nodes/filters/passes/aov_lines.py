"""Lines from the passes of a render: where surfaces end, touch, change material, or fold."""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Uint32
from flowabs_nodes.choices import PROJECTIONS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.passes.affine_depth import View, affine_depth, no_depth
from flowabs_nodes.filters.passes.cracks import Passes, find_cracks
from flowabs_nodes.filters.passes.creases import alone, find_creases, unit_normals
from flowabs_nodes.filters.passes.draw import Pens, draw
from flowabs_nodes.filters.passes.edges import between, edges_of, no_edges
from flowabs_nodes.filters.passes.fit import directed, fitted
from flowabs_nodes.filters.passes.id_borders import id_borders
from flowabs_nodes.filters.passes.own_depth import own_depth
from flowabs_nodes.filters.passes.own_material import own_material
from flowabs_nodes.filters.passes.passes_flow import passes_flow


class AovLines(NamedTuple):
    """What :func:`aov_lines` draws, (H, W) float32 each; None what was not asked for."""

    lines: Array  # 1 paper, 0 ink
    outline: Array | None  # the ink of each kind, 0 to 1
    object: Array | None
    material: Array | None
    crease: Array | None
    intersection: Array | None
    strength: Array | None  # 0 to 1: of the nearest edge, within 2 px
    distance: Array | None  # px, to the nearest edge: positive where its ink lies; of a crease, to its middle
    flow: Array | None  # (H, W, 2)


#: The kinds of edges, in the order of the codes in ``edges.py``.
_KINDS = ("outline", "object", "material", "crease", "intersection")


def aov_lines(
    depth: npt.ArrayLike | None = None,
    normal: npt.ArrayLike | None = None,
    id: npt.ArrayLike | None = None,
    coverage: npt.ArrayLike | None = None,
    material: npt.ArrayLike | None = None,
    *,
    width: float = 1.5,
    crease_width: float = 1.5,
    depth_step: float = 0.02,
    crease_angle: float = 30.0,
    crease_reach: float = 1.0,
    sigma_m: float = 2.0,
    radius: float = 5.0,
    iterations: int = 3,
    projection: str = "planar",
    field_of_view: float = 40.0,
    view: View | None = None,
    outputs: Collection[str] = AovLines._fields,
) -> AovLines:
    """Return lines along the edges that a render's passes show: steady, of even width, whatever the light.

    A line lies on the near side of its edge; on both of a crease, and where two objects touch (``edges.py``). Depth
    makes an edge where one surface lies before another (``cracks.py``), ids wherever two objects meet, normals where a
    surface folds (``creases.py``). The edges' pixel staircases become smooth lines by fitting straight pieces
    (``fit.py``).

    Parameters
    ----------
    depth
        (H, W), distance from the camera in any unit. Background: 1e9 and more, 65504, NaN, Inf, and 0 and below.
    normal
        (H, W, 3), in any space; need not be of length 1. Normals that are not finite, or about 0, make no crease.
    id
        (H, W) uint32, or other whole numbers; 0 is the background. Each id is an object.
    coverage
        (H, W), 0 to 1: how much of the pixel its id covers. Puts the lines between ids where the edges are within a
        pixel, for clean renders; a pixel that its id does not cover at all counts as background.
    material
        (H, W) whole numbers as ``id``: materials within an object.
    width, crease_width
        Width of lines, and of creases, in pixels, 0.5 to 8.
    depth_step
        Step in depth, as a part of the distance, from which an edge has full strength: 0.0001 to 1. Soft from a quarter
        of it on.
    crease_angle
        Angle in degrees, above 0 and up to 180, by which normals turn at a crease of full strength, beyond what they
        turn beside it. Soft from half of it on.
    crease_reach
        How far to either side of a crease normals are compared, in pixels, 0.5 to 20: more finds blunter folds.
    sigma_m
        Sigma in pixels, 0 to 20, of the average along an edge that makes a staircase smooth.
    radius, iterations
        Of the flow: the kernel's radius in pixels, at least 0, and how often it is smoothed (:func:`etf`).
    projection
        What depth is: "planar", Z along the camera's axis; "distance" from the camera along the ray; "orthographic".
    field_of_view
        The angle in degrees that the view's width covers, 1 to 179; for "distance".
    view
        Where the camera's axis meets the picture, for "distance"; None: its middle, and the picture is all there is.
    outputs
        Names of what is asked for; ``lines`` are made in any case. What is None saves time.

    Raises
    ------
    ArgumentError
        None of depth, normal and id is given, passes differ in size, or a parameter is out of range.
    """
    if depth is None and normal is None and id is None:
        raise ArgumentError("expected at least one of depth, normal and id, found none", code="missing-input")
    width = validate.number("width", width, min=0.5, max=8)
    crease_width = validate.number("crease_width", crease_width, min=0.5, max=8)
    depth_step = validate.number("depth_step", depth_step, min=1e-4, max=1)
    crease_angle = validate.number("crease_angle", crease_angle, above=0, max=180)
    crease_reach = validate.number("crease_reach", crease_reach, min=0.5, max=20)
    sigma_m = validate.number("sigma_m", sigma_m, min=0, max=20)
    radius = validate.number("radius", radius, min=0)
    iterations = validate.whole("iterations", iterations, min=0)
    validate.choice("projection", projection, PROJECTIONS)
    field_of_view = validate.number("field_of_view", field_of_view, min=1, max=179)
    for name in outputs:
        validate.choice("outputs", name, AovLines._fields)
    height, wide = _shape(depth=depth, normal=normal, id=id)
    depth_pass, normals = _depth(depth, (height, wide)), _normals(normal, (height, wide))
    ids, materials = _ids("id", id, (height, wide)), _ids("material", material, (height, wide))
    covered = _coverage(coverage, ids)
    if covered.size:
        ids = np.where(covered > 0, ids, np.uint32(0))

    seen, borders = no_depth(), id_borders(ids)
    if depth_pass is not None:
        middle = View((wide - 1) / 2, (height - 1) / 2, wide)
        seen = affine_depth(depth_pass, projection, field_of_view, view or middle)
        if ids.size:
            seen = own_depth(seen, ids, borders)
    if ids.size and materials.size:
        materials = own_material(materials, ids, borders)
    cracks = find_cracks(Passes(*seen, ids, covered, materials), height, depth_step)
    edges = fitted(directed(edges_of(cracks, depth_step, depth is not None)), sigma_m)
    unit = None if normals is None else unit_normals(normals)
    creases = no_edges(height)
    if unit is not None:
        found = alone(*find_creases(unit, crease_angle, crease_reach), edges)
        creases = fitted(directed(found, two_sided=True), sigma_m, two_sided=True)

    edges = between(edges, width)
    measured = "strength" in outputs or "distance" in outputs
    apart = any(name in outputs for name in _KINDS)
    pens = Pens(width, crease_width)
    drawing = draw(edges, creases, pens, height, wide, apart=apart, measured=measured)
    flow = passes_flow(edges, unit, (height, wide), radius, iterations) if "flow" in outputs else None
    kinds = dict(zip(_KINDS, drawing.kinds, strict=True)) if apart else dict.fromkeys(_KINDS)
    return AovLines(
        lines=drawing.lines,
        **kinds,
        strength=drawing.strength if measured else None,
        distance=drawing.distance if measured else None,
        flow=flow,
    )


def _shape(**given: npt.ArrayLike | None) -> tuple[int, int]:
    """Return the height and width of the first pass that is given."""
    name, first = next((name, np.asarray(each)) for name, each in given.items() if each is not None)
    if first.ndim < 2 or first.shape[0] * first.shape[1] == 0:
        raise ArgumentError(f"{name}: expected a picture of at least one pixel, found {first.shape}", parameter=name)
    return first.shape[0], first.shape[1]


def _depth(depth: npt.ArrayLike | None, shape: tuple[int, int]) -> Array | None:
    return None if depth is None else validate.plane("depth", depth, shape, check_finite=False)


def _normals(normal: npt.ArrayLike | None, shape: tuple[int, int]) -> Array | None:
    return None if normal is None else validate.planes("normal", normal, shape, check_finite=False)


def _ids(name: str, value: npt.ArrayLike | None, shape: tuple[int, int]) -> Uint32:
    """Return whole numbers as (H, W) uint32, of no pixels where there are none."""
    if value is None:
        return np.empty((0, 0), np.uint32)
    return validate.ids(name, value, shape)


def _coverage(coverage: npt.ArrayLike | None, ids: Uint32) -> Array:
    """Return the coverage of ids as (H, W), of no pixels where there is none."""
    if coverage is None:
        return np.empty((0, 0), np.float32)
    if not ids.size:
        raise ArgumentError("coverage: needs the id pass that it belongs to", code="missing-input", parameter="id")
    covered = validate.plane("coverage", coverage, ids.shape, check_finite=False)
    return np.where(covered > 0, np.minimum(covered, 1), np.float32(0))  # NaN covers nothing
