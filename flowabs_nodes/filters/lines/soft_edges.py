"""Soft outlines as one line of normal width: what FDoG's responses lack at blurred edges, made good."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_blur import along
from flowabs_nodes.filters.flow.flow_resolution import Flows
from flowabs_nodes.filters.gaussian_blur import separable
from flowabs_nodes.filters.lines.edge_model import EdgeModel, missing_response
from flowabs_nodes.filters.lines.soft_reach import Lengths, lengths
from flowabs_nodes.filters.working_scale import soft_edges_factor
from flowabs_nodes.sampling.resolution import enlarged, reduced_planes
from flowabs_nodes.sampling.tile_cache import ROWS, PlanesShape, pad_width
from flowabs_nodes.simd.bands import over_rows


@dataclass(frozen=True)
class SoftEdges:
    """How soft outlines are drawn, with the parameters checked."""

    lengths: Lengths
    model: EdgeModel
    factor: int  # by which the lines' picture is reduced once more

    @classmethod
    def checked(
        cls,
        soft_lines: float,
        soft_reach: float,
        *,
        sigma_c: float,
        rho: float,
        color_weight: float,
        pre_blur: float = 0.0,
        working_scale: str = "full",
        factor: int = 1,
    ) -> SoftEdges | None:
        """Return how soft outlines are drawn, None where ``soft_lines`` is 0; raise ArgumentError for a bad parameter.

        ``sigma_c``, ``rho``, ``color_weight`` and ``pre_blur`` are those of the line filter, checked already. An edge
        shall look as a sharp one does after ``pre_blur``, or after a blur of sigma_c where that is less: whatever more
        blur the filter gets against noise does not make its lines fainter. ``factor`` is that by which the lines'
        picture is reduced; what edges lack is measured at that size, or at a smaller one where ``working_scale`` and
        ``soft_reach`` allow it. All lengths are those of the full size.
        """
        amount = validate.number("soft_lines", soft_lines, min=0, max=1)
        reach = validate.number("soft_reach", soft_reach, min=1, max=10_000)
        if amount == 0:
            return None
        own = max(factor, soft_edges_factor(working_scale, lengths(reach).t))
        each, sigma_c, pre_blur = lengths(reach / own), sigma_c / own, pre_blur / own
        wanted = min(pre_blur, sigma_c)
        numbers = (
            each.t,
            each.d,
            each.e,
            color_weight,
            amount,
            rho,
            sigma_c**2,
            (gaussian.SURROUND * sigma_c) ** 2,
            pre_blur**2,
            wanted**2,
        )
        return cls(each, EdgeModel(*map(np.float32, numbers)), own // factor)

    def missing(self, planes: Array, flows: Flows) -> Array:
        """Return what to add to the sums across the flow (eq. 10) of planes (C, H, W) of code values, (C, H, W)."""
        small, flow = reduced_planes(planes, self.factor), flows.reduced(self.factor)
        t = self.lengths.t
        weights = gaussian.every(max(1, round(t / 2)), gaussian.half(t))  # of what is as smooth as t
        found = along(self._found(small, flow), flow, weights, "bilinear")
        return enlarged(found, self.factor, *planes.shape[1:])

    def _found(self, planes: Array, flow: Array) -> Array:
        """Return what is missing at each pixel for itself."""
        height, width = planes.shape[1:]
        blurred = np.empty_like(planes)
        for plane, result in zip(planes, blurred, strict=True):
            separable(plane, gaussian.half(self.lengths.t), result)
        blurred, flow = pad_width(blurred, 2), pad_width(flow, 1)
        found = np.empty_like(blurred)
        pictures = blurred.reshape(-1), PlanesShape(*blurred.shape), flow.reshape(-1).view(np.complex64)
        over_rows(missing_response, height, *pictures, self.model, found.reshape(-1), least=ROWS)
        return np.ascontiguousarray(found[..., :width])
