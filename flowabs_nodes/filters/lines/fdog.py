"""The flow-based difference of Gaussians (section 3.1): apply a line detector across the flow, sum along the flow."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.choices import FDOG_KERNELS, SAMPLINGS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_blur import along, as_planes
from flowabs_nodes.filters.flow.flow_resolution import Flows, reduced_flow
from flowabs_nodes.filters.lines.dog_line import across
from flowabs_nodes.filters.lines.evidence import Evidence
from flowabs_nodes.filters.lines.join_channels import join_channels
from flowabs_nodes.filters.lines.soft_edges import SoftEdges
from flowabs_nodes.filters.lines.thin_lines import ThinLines
from flowabs_nodes.filters.working_scale import (
    READ_TWICE,
    evidence_factor,
    lines_factor,
    shortened_blur,
    step_across,
    step_along,
)
from flowabs_nodes.sampling.exact_sums import exact_sum
from flowabs_nodes.sampling.resolution import enlarged, reduced
from flowabs_nodes.simd.bands import limited, over_rows


def fdog(
    code: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_m: float = 3.0,
    sigma_c: float = 1.0,
    rho: float = 0.99,
    color_weight: float = 0.0,
    kernel: str = "separable",
    sampling: str = "bilinear",
    color_sign: bool = False,
    evidence: float = 0.0,
    soft_lines: float = 0.0,
    soft_reach: float = 7.0,
    thin_lines: float = 0.0,
    lone_lines: float = 0.0,
    working_scale: str = "full",
) -> Array:
    """Return the response H of the FDoG filter, eqs. 6-8, 10, 11: below 0 on dark lines and on the dark side of edges.

    Parameters
    ----------
    code
        Code values, (H, W), or (H, W, 3), whose second and third channel only count with ``color_weight``.
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    sigma_m
        Sigma of the Gaussian along the flow in pixels, 0 to 10,000: the length of lines. 0 is the pixel alone.
    sigma_c
        Sigma of the inner Gaussian across the flow in pixels, above 0, at most 10,000: the width of lines.
    rho
        Weight of the outer Gaussian, which is 1.6 times as wide: 0 to 2, typically 0.97 to 1. Where code values are
        constant, H = (1 - rho) I.
    color_weight
        Weight w of the second and third channel, 0 to 1e6: with d_L, d_a, d_b the responses of the three channels,
        H = M tanh(2 d_L), M = sqrt(d_L^2 + w^2 (d_a^2 + d_b^2)).
    kernel
        "separable": sum across the flow, then along it (eqs. 10, 11); "full": eq. 6, with a gradient axis through every
        point of the streamline rather than through the pixels near the point. "full" costs as many times more as the
        streamline has steps.
    sampling
        How samples are taken along the streamline, "bilinear" or at the "nearest" pixel. Samples along the gradient
        axis are always bilinear.
    color_sign
        Whether edges of equal lightness are drawn: where |d_L| is small beside m_c = w sqrt(d_a^2 + d_b^2), the dark
        side of an edge is that of less 0.4 a + 0.7 b. With t = smoothstep(0.1, 0.3, |d_L| / m_c), 1 where m_c is 0,
        the sign is s = t tanh(2 d_L) + (1 - t) tanh(2 w (0.4 d_a + 0.7 d_b)), and H = M s. A continuous sign that is
        opposite on the two sides of every edge must be 0 at some hue. So where colour alone makes an edge, both sides
        of it are dark rather than none: with q = smoothstep(1, 2, m_c), H = M ((1 - q) s + q (2 smoothstep(0, 1, s) -
        1)). Counts with ``color_weight``.
    evidence
        0 to 1: how much weaker H becomes where it is below 0 at places but not along a stretch three times as long
        (:mod:`~flowabs_nodes.filters.lines.evidence`). 0 leaves H as it is.
    soft_lines
        How far soft edges get the line of sharp ones, 0 to 1: what f lacks across an edge that is blurred, by the edge
        model (:mod:`~flowabs_nodes.filters.lines.edge_model`), is added before the sum along the flow. 0 adds nothing.
    soft_reach
        The blur of the softest edges that get it, sigma in pixels, 1 to 10,000. Edges must be alone over about as many
        pixels to either side. Counts with ``soft_lines``.
    thin_lines
        Width in pixels, 0 to 10,000, up to which a bright line that is alone gets one line on its middle rather than
        one along each side (:mod:`~flowabs_nodes.filters.lines.thin_lines`). 0 leaves bright lines as they are.
    lone_lines
        0 to 1000: how many times its own strength a faint line gains where it is alone, up to as far as evidence looks.
        0 leaves H as it is.
    working_scale
        The size of the picture that is worked on: "full"; "1/2" or "1/4" of its width and height, sigmas to match, the
        responses of the channels brought back up; or "auto": 1/2 where it leaves ``sigma_c`` at least 2 pixels, 1/4
        where it leaves 4. What soft edges lack, and evidence, are looked for at 1/2 where ``soft_reach`` is at least 12
        pixels, and ``sigma_c`` 2.8.

    Returns
    -------
    H in code values, (H, W) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    code = validate.plane_or_planes("code", code, summed=True)
    flow = validate.flow_field(flow, code.shape)
    detector = Detector.checked(sigma_m, sigma_c, rho, color_weight, kernel, sampling, color_sign, working_scale)
    weighing = Evidence.checked(evidence, lone_lines)
    soft = SoftEdges.checked(
        soft_lines,
        soft_reach,
        sigma_c=sigma_c,
        rho=rho,
        color_weight=color_weight,
        working_scale=working_scale,
        factor=detector.factor,
    )
    thin = ThinLines.checked(thin_lines, sigma_c=sigma_c, rho=rho, working_scale=working_scale, factor=detector.factor)
    planes, flows = detector.reduced(code, flow)
    missing = None if soft is None else soft.missing(planes, flows)
    if thin is not None:
        missing = thin.added(missing, planes, flows)
    return detector.response(planes, flows, code.shape[:2], missing, weighing)


@dataclass(frozen=True)
class Detector:
    """The FDoG filter with its parameters checked and its weights computed."""

    weights: Float64  # G_sigma_m at s = 0, 1 .. S
    taps: Float64  # f (eq. 8) at t = 0, 1 .. T
    color_weight: float
    full: bool
    sampling: str
    color_sign: bool
    sigma_m: float  # of the size that is worked on
    factor: int  # by which the picture is reduced, and lengths are shortened
    evidence_factor: int  # and by which evidence is looked for

    @classmethod
    def checked(
        cls,
        sigma_m: float,
        sigma_c: float,
        rho: float,
        color_weight: float,
        kernel: str,
        sampling: str,
        color_sign: bool,
        working_scale: str,
        passes: int = 1,
        pre_blur: float = 0.0,
    ) -> Detector:
        """Return the filter with the parameters of :func:`fdog`; raise ArgumentError for a bad one.

        ``passes`` and ``pre_blur`` are those of :func:`~flowabs_nodes.filters.fdog_iterative`, checked.
        """
        sigma_m = validate.number("sigma_m", sigma_m, min=0, max=10_000)
        sigma_c = validate.number("sigma_c", sigma_c, above=0, max=10_000)
        rho = validate.number("rho", rho, min=0, max=2)
        factor = lines_factor(working_scale, sigma_c, passes, pre_blur)
        inner, outer = (shortened_blur(s, factor, READ_TWICE) for s in (sigma_c, gaussian.SURROUND * sigma_c))
        apart = step_along(working_scale, sigma_m / factor, pre_blur / factor)
        apart_across = step_across(working_scale, sigma_c / factor, pre_blur / factor)
        return cls(
            weights=gaussian.every(apart, gaussian.half(sigma_m / factor)),
            taps=gaussian.difference(inner, rho, outer, apart_across),
            color_weight=validate.number("color_weight", color_weight, min=0, max=1e6),
            full=validate.choice("kernel", kernel, FDOG_KERNELS) == "full",
            sampling=validate.choice("sampling", sampling, SAMPLINGS),
            color_sign=validate.flag("color_sign", color_sign),
            sigma_m=sigma_m / factor,
            factor=factor,
            evidence_factor=max(factor, evidence_factor(working_scale, sigma_c, pre_blur)),
        )

    def reduced(self, code: Array, flow: Array) -> tuple[Array, Flows]:
        """Return the planes (C, h, w) of the channels that count, and the flow, both of the size that is worked on."""
        counts = code if self.color_weight > 0 or code.ndim == 2 else code[..., 0]
        return as_planes(reduced(counts, self.factor)), Flows(reduced_flow(flow, self.factor))

    def response(
        self,
        planes: Array,
        flows: Flows,
        size: tuple[int, ...],
        missing: Array | None = None,
        evidence: Evidence | None = None,
    ) -> Array:
        """Return H, (H, W), of planes (C, h, w) of code values and the flow of the size that is worked on.

        ``size`` is H and W: those of the planes, or of the full picture, to which H is brought up. ``missing``, (C, h,
        w), is added to the sums across the flow.
        """
        flow = flows.reduced(1)
        if self.full:
            responses = exact_sum(planes, flow, self.taps, self.weights, self.sampling)  # eq. 6
            if missing is not None:
                responses += along(missing, flow, self.weights, self.sampling)
        else:
            sums = across(planes, flow, self.taps)  # eq. 10
            del planes
            if missing is not None:
                _add(sums, missing)
            responses = along(sums, flow, self.weights, self.sampling)  # eq. 11
            del sums
        at_work = size == responses.shape[1:]
        if at_work or evidence is not None:
            joined = self._joined(responses)
        if at_work and evidence is None:
            return joined
        if at_work:
            del responses  # whose memory serves what follows
        if evidence is not None:
            found = evidence.found(joined, flows, self.sigma_m, self.evidence_factor // self.factor)
        response = np.empty(size, np.float32)

        def band(first: int, last: int) -> None:
            """Compute the rows ``first`` .. ``last`` - 1: so little is held at full size."""
            with limited(1):  # the bands are what threads share
                brought_up = partial(enlarged, height=size[0], width=size[1], first=first, last=last)
                rows = joined[first:last] if at_work else self._joined(brought_up(responses, self.factor))
                if evidence is not None:
                    at_size = found.each(lambda plane: brought_up(plane[None], self.evidence_factor)[0])
                    rows = evidence.weighed(rows, at_size)
                response[first:last] = rows

        over_rows(band, size[0])
        return response

    def _joined(self, responses: Array) -> Array:
        """Return H, (H, W), of the channels' responses (C, H, W) before evidence is asked for."""
        return join_channels(responses, self.color_weight, self.color_sign)


def _add(sums: Array, missing: Array) -> None:
    """Add planes (C, H, W) to others, by all threads."""

    def band(first: int, last: int) -> None:
        sums[:, first:last] += missing[:, first:last]

    over_rows(band, sums.shape[1])
