"""Thin bright lines as one line: whiskers, cables and bright rims are drawn on their middle, not along both sides.

A dark line gets one line of ink. A bright one gets two, since ink lies on the dark side of edges. So it is mirrored at
its ground first, which makes a dark line of it: with D what it is brighter than the ground, the picture P becomes
P - 2 D. FDoG is linear across the flow, so what that adds to its sums (eq. 10) is found once, and added in each pass.

What is thin, and alone, is told by openings and closings across the flow (a top-hat transform: Meyer, "Iterative image
transformations for an automatic screening of cervical smears", 1979), Q the lightness and W the width:

    T = Q - opening_W(closing_2W(Q)),  thin parts, and no texture: gaps of less than 2 W between bright parts are closed
    B = Q - opening_2W(Q),             parts of up to twice the width
    D = lambda min(B, 3 T),            lambda = smoothstep(.55, .75, T' / B') smoothstep(8, 20, T')

T' and B' are T and B along the flow, G(2 W), so that a line is one line or two over a whole stretch of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_blur import along
from flowabs_nodes.filters.flow.flow_resolution import Flows
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.lines.dog_line import across
from flowabs_nodes.filters.lines.extrema_across import closing, opening
from flowabs_nodes.filters.working_scale import READ_TWICE, shortened_blur, thin_lines_factor
from flowabs_nodes.sampling.resolution import enlarged, reduced
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import Floats, maximum, minimum
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels

#: A line is thin between the first and the second of these T' / B' fully, or not at all. Between them it is mirrored in
#: part, which leaves next to no line: so they are not far apart.
_WIDE, _THIN = 0.55, 0.75
#: The same of T' in code values: what is hardly brighter than its ground is noise.
_FAINT, _CLEAR = 8.0, 20.0
_MOST = 3.0  # times T is mirrored at most, where the line's foot is wider than W


@dataclass(frozen=True)
class ThinLines:
    """How thin bright lines are drawn, with the parameters checked."""

    width: float  # W in pixels of the size that they are looked for at, as are all lengths here
    taps: Float64  # f (eq. 8)
    pre_blur: float  # sigma of the blur that the line filter's picture gets
    factor: int  # by which the lines' picture is reduced once more

    @classmethod
    def checked(
        cls,
        thin_lines: float,
        *,
        sigma_c: float,
        rho: float,
        pre_blur: float = 0.0,
        working_scale: str = "full",
        factor: int = 1,
    ) -> ThinLines | None:
        """Return how thin bright lines are drawn, None where ``thin_lines`` is 0; raise ArgumentError if it is bad.

        ``sigma_c``, ``rho`` and ``pre_blur`` are those of the line filter, checked already. ``factor`` is that by which
        the lines' picture is reduced; lines are looked for at that size, or at a smaller one where ``working_scale``
        and their width allow it. All lengths are those of the full size.
        """
        width = validate.number("thin_lines", thin_lines, min=0, max=10_000)
        if width == 0:
            return None
        own = max(factor, thin_lines_factor(working_scale, width, sigma_c, pre_blur))
        inner, outer = (shortened_blur(s, own, READ_TWICE) for s in (sigma_c, gaussian.SURROUND * sigma_c))
        return cls(width / own, gaussian.difference(inner, rho, outer), pre_blur / own, own // factor)

    def added(self, missing: Array | None, planes: Array, flows: Flows) -> Array:
        """Return ``missing``, what is added to the sums across the flow of planes (C, H, W), with thin lines' part.

        That is added in its own memory; None is nothing. Only the first plane, lightness, is mirrored.
        """
        flow = flows.reduced(self.factor)
        mirrored = mirror(reduced(planes[0], self.factor), flow, self.width)
        if self.pre_blur > 0:
            mirrored = blur(mirrored, self.pre_blur)
        total = np.zeros_like(planes) if missing is None else missing
        total[0] += enlarged(across(mirrored[None], flow, self.taps), self.factor, *planes.shape[1:])[0]
        return total


def mirror(lightness: Array, flow: Array, width: float) -> Array:
    """Return -2 D, (H, W): what makes dark lines of the bright lines of up to ``width`` pixels in a picture (H, W)."""
    ground = opening(closing(lightness, flow, 2 * width), flow, width)
    thin, wide = np.maximum(lightness - ground, 0), np.maximum(lightness - opening(lightness, flow, 2 * width), 0)
    stretch = along(np.stack([thin, wide]), flow, gaussian.half(2 * width), "nearest")
    result = empty_run(thin.size)
    over_pixels(_mirror, thin.size, as_run(thin), as_run(wide), as_run(stretch[0]), as_run(stretch[1]), result)
    return as_picture(result, *thin.shape)


@kernel
def _mirror(first: int, last: int, thin: Array, wide: Array, thin_along: Array, wide_along: Array, result: Any) -> None:
    """Write -2 lambda min(B, 3 T) for the blocks ``first`` .. ``last`` - 1 of sixteen pixels."""
    for block in range(first, last):
        i = first_pixel(block, result.size)
        t, t_along, b_along = load(thin, i), load(thin_along, i), load(wide_along, i)
        share = t_along / maximum(b_along, 1e-3)
        weight = _rise((share - _WIDE) / (_THIN - _WIDE)) * _rise((t_along - _FAINT) / (_CLEAR - _FAINT))
        store(result, i, -2.0 * weight * minimum(load(wide, i), _MOST * t))


@inlined
def _rise(x: Floats) -> Floats:
    """Return smoothstep(0, 1, x)."""
    x = minimum(maximum(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)
