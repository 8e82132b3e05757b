"""Edges that are known from elsewhere, as from a render's passes, added to the gradient that a flow starts from.

An edge of strength s along the unit tangent f counts like a gradient e of ``weight`` s code values per pixel across it.
With the picture's own gradient g both go into one structure tensor,

    J = g g^T + e e^T,   e = weight s f',   f' normal to f.

The new tangent is normal to the major eigenvector of J, the new magnitude the root of its eigenvalue: of two gradients
along one line |g|^2 and |e|^2 add up, else the stronger one decides. ĝ of eq. 3 comes of the new magnitude.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.flow.flow_resolution import reduced_flow
from flowabs_nodes.filters.flow.gradient import Gradient, Measured, tangent_of_tensor
from flowabs_nodes.sampling.resolution import reduced
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import maximum, minimum, select, to_doubles
from flowabs_nodes.simd.memory import load, load_pairs, store, store_pairs
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels


class Edges(NamedTuple):
    """Edges that are known."""

    strength: Array  # (H, W), 0 to 1
    flow: Array  # (H, W, 2), tangents along them
    weight: float  # the gradient that full strength counts as, in code values per pixel

    def reduced(self, factor: int) -> Edges:
        """Return the edges of a picture that is smaller by ``factor``: there a gradient is as much larger."""
        return Edges(reduced(self.strength, factor), reduced_flow(self.flow, factor), self.weight * factor)


def edges_of(
    strength: npt.ArrayLike | None, flow: npt.ArrayLike | None, weight: float, shape: tuple[int, ...]
) -> Edges | None:
    """Return the arguments ``edge_strength``, ``edge_flow`` and ``edge_weight``, checked; None if there are no edges.

    Raises ArgumentError for another shape or dtype, numbers that are not finite, or one of both alone.
    """
    weight = validate.number("edge_weight", weight, min=0, max=1e6)
    if strength is None and flow is None:
        return None
    if flow is None:
        raise ArgumentError("edge_strength needs edge_flow too", code="missing-input", parameter="edge_strength")
    if strength is None:
        raise ArgumentError("edge_flow needs edge_strength too", code="missing-input", parameter="edge_flow")
    known = validate.plane("edge_strength", strength, shape)
    return Edges(known, validate.flow_field(flow, shape, "edge_flow"), weight)


def with_edges(made: Measured, edges: Edges) -> Measured:
    """Return a gradient with edges added to it; its very bits where their strength is 0."""
    tangent, magnitude = made.gradient
    strong = as_run(magnitude)
    turned, stronger = empty_run(magnitude.size, 2), empty_run(magnitude.size)
    known = as_run(edges.strength), as_run(edges.flow, 2), np.float32(edges.weight)
    over_pixels(_add_edges, strong.size, as_run(tangent, 2), strong, *known, turned, stronger)
    summed = Gradient(as_picture(turned, *tangent.shape), as_picture(stronger, *magnitude.shape))
    return Measured(summed, float(summed.magnitude.max()), made.everywhere)


@kernel
def _add_edges(
    first: int,
    last: int,
    tangent: Array,
    magnitude: Array,
    strength: Array,
    flow: Array,
    weight: float,
    turned: Array,
    stronger: Array,
) -> None:
    """Write tangents and magnitudes of J in the blocks ``first`` .. ``last`` - 1 of sixteen pixels."""
    for block in range(first, last):
        i = first_pixel(block, magnitude.size)
        tx, ty = load_pairs(tangent, 2 * i)
        m = load(magnitude, i)
        e = weight * minimum(maximum(load(strength, i), 0.0), 1.0)
        # g g^T of the gradient g = |g| (t.y, -t.x), and e e^T, by their double angles and traces.
        gx, gy = to_doubles(m) * to_doubles(ty), -to_doubles(m) * to_doubles(tx)
        fx, fy = load_pairs(flow, 2 * i)
        ex, ey = to_doubles(e) * to_doubles(fy), -to_doubles(e) * to_doubles(fx)
        c = (gx * gx - gy * gy) + (ex * ex - ey * ey)
        s = 2.0 * (gx * gy) + 2.0 * (ex * ey)
        x, y, largest = tangent_of_tensor(c, s, (gx * gx + gy * gy) + (ex * ex + ey * ey))
        known = e > 0.0
        directed = known & (x * x + y * y > 0.0)  # two gradients as strong across each other leave the tangent
        store_pairs(turned, 2 * i, (select(directed, x, tx), select(directed, y, ty)))
        store(stronger, i, select(known, largest, m))
