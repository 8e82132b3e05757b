"""The flow-based difference of Gaussians (section 3.1): a line detector across the flow, summed along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.choices import FDOG_KERNELS, SAMPLINGS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_blur import along, planes_of
from flowabs_nodes.filters.lines.dog_line import across
from flowabs_nodes.filters.validate import Array
from flowabs_nodes.sampling.exact_sums import full
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.exponential import LOG2_E, exp2
from flowabs_nodes.simd.jit import kernel


def fdog(
    code: npt.ArrayLike,
    flow: npt.ArrayLike,
    sigma_m: float = 3.0,
    sigma_c: float = 1.0,
    rho: float = 0.99,
    color_weight: float = 0.0,
    kernel: str = "separable",
    sampling: str = "bilinear",
) -> Array:
    """Response H of the FDoG filter, eqs. 6-8, 10 and 11: below 0 on dark lines and on the dark side of edges.

    Parameters
    ----------
    code
        Code values, (H, W), or (H, W, 3), of which the second and third channel only count with ``color_weight``.
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
        Weight w of the second and third channel, 0 to 1e6: with d the channels' responses,
        H = tanh(2 d_L) sqrt(d_L^2 + w^2 (d_a^2 + d_b^2)).
    kernel
        "separable": across the flow, then along it (eqs. 10, 11); "full": eq. 6, with a gradient line through every
        point of the curve rather than through the pixels near it. It costs as many times more as the curve has steps.
    sampling
        How the curve is read, "bilinear" or "nearest" pixel. The gradient line is always read bilinearly.

    Returns
    -------
    H in code values, (H, W) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    code = validate.plane_or_planes("code", code)
    flow = validate.flow_field(flow, code.shape)
    detector = Detector.checked(sigma_m, sigma_c, rho, color_weight, kernel, sampling)
    return detector.response(planes_of(code if color_weight > 0 or code.ndim == 2 else code[..., 0]), flow)


@dataclass(frozen=True)
class Detector:
    """The filter with its parameters checked and its weights worked out."""

    weights: npt.NDArray[np.float64]  # G_sigma_m, one side
    taps: npt.NDArray[np.float64]  # f, one side
    color_weight: float
    full: bool
    sampling: str

    @classmethod
    def checked(
        cls, sigma_m: float, sigma_c: float, rho: float, color_weight: float, kernel: str, sampling: str
    ) -> Detector:
        sigma_m = validate.number("sigma_m", sigma_m, min=0, max=10_000)
        sigma_c = validate.number("sigma_c", sigma_c, above=0, max=10_000)
        rho = validate.number("rho", rho, min=0, max=2)
        return cls(
            weights=gaussian.half(sigma_m),
            taps=gaussian.difference(sigma_c, rho),
            color_weight=validate.number("color_weight", color_weight, min=0, max=1e6),
            full=validate.choice("kernel", kernel, FDOG_KERNELS) == "full",
            sampling=validate.choice("sampling", sampling, SAMPLINGS),
        )

    def response(self, planes: Array, flow: Array) -> Array:
        """H of a picture (C, H, W), its first plane alone without a weight for colour."""
        planes = planes if self.color_weight > 0 else planes[:1]
        if self.full:
            responses = full(planes, flow, self.taps, self.weights, self.sampling)
        else:
            responses = along(across(planes, flow, self.taps), flow, self.weights, self.sampling)
        if self.color_weight == 0:
            first: Array = responses[0]
            return first
        joined = np.empty(flow.shape[:2], np.float32)
        over_rows(_join, flow.shape[0], responses, np.float32(self.color_weight), joined)
        return joined


@kernel
def _join(first: int, last: int, responses: Any, weight: Any, joined: Any) -> None:
    """H of all channels together."""
    is_color = responses.shape[0] > 1
    for y in range(first, last):
        for x in range(joined.shape[1]):
            d = responses[0, y, x]
            a = weight * responses[1, y, x] if is_color else np.float32(0.0)
            b = weight * responses[2, y, x] if is_color else np.float32(0.0)
            # tanh(2 |d|) = (1 - e) / (1 + e) with e = exp(-4 |d|)
            e = exp2(np.float32(-4 * LOG2_E) * abs(d))
            strength = (np.float32(1.0) - e) / (np.float32(1.0) + e) * np.sqrt(d * d + a * a + b * b)
            joined[y, x] = -strength if d < 0 else strength
