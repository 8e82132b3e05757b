"""The flow-based difference of Gaussians (section 3.1): a line detector across the flow, summed along it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.filters import arguments, gaussian
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.blocks import COLUMNS, Block, first_pixel, scratch, u
from flowabs_nodes.filters.exponential import LOG2_E, exp2
from flowabs_nodes.filters.flow_blur import along, planes_of
from flowabs_nodes.filters.gradient_line import across
from flowabs_nodes.filters.kernels import kernel
from flowabs_nodes.filters.sampling import SAMPLINGS, find, new_between, read_between, records, snap
from flowabs_nodes.filters.threads import over_rows
from flowabs_nodes.filters.walk import new_walk, start, step


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
    code = arguments.plane_or_planes("code", code)
    flow = arguments.flow_field(flow, code.shape)
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
        sigma_m = arguments.number("sigma_m", sigma_m, min=0, max=10_000)
        sigma_c = arguments.number("sigma_c", sigma_c, above=0, max=10_000)
        rho = arguments.number("rho", rho, min=0, max=2)
        return cls(
            weights=gaussian.half(sigma_m),
            taps=gaussian.difference(sigma_c, rho),
            color_weight=arguments.number("color_weight", color_weight, min=0, max=1e6),
            full=arguments.choice("kernel", kernel, ("separable", "full")) == "full",
            sampling=arguments.choice("sampling", sampling, SAMPLINGS),
        )

    def response(self, planes: Array, flow: Array) -> Array:
        """H of a picture (C, H, W), its first plane alone without a weight for colour."""
        planes = planes if self.color_weight > 0 else planes[:1]
        if self.full:
            responses = _full(planes, flow, self.taps, self.weights, self.sampling)
        else:
            responses = along(across(planes, flow, self.taps), flow, self.weights, self.sampling)
        if self.color_weight == 0:
            return responses[0]
        joined = np.empty(flow.shape[:2], np.float32)
        over_rows(_join, flow.shape[0], responses, np.float32(self.color_weight), joined)
        return joined


@kernel
def _join(first: int, last: int, responses: Any, weight: Any, joined: Any) -> None:
    """H of all channels together."""
    is_color = responses.shape[0] > 1
    for y in range(first, last):
        for x in range(u(joined.shape[1])):
            d = responses[0, y, x]
            a = weight * responses[1, y, x] if is_color else np.float32(0.0)
            b = weight * responses[2, y, x] if is_color else np.float32(0.0)
            # tanh(2 |d|) = (1 - e) / (1 + e) with e = exp(-4 |d|)
            e = exp2(np.float32(-4 * LOG2_E) * abs(d))
            strength = (np.float32(1.0) - e) / (np.float32(1.0) + e) * np.sqrt(d * d + a * a + b * b)
            joined[y, x] = -strength if d < 0 else strength


def _full(
    planes: Array, flow: Array, taps: npt.NDArray[np.float64], weights: npt.NDArray[np.float64], sampling: str
) -> Array:
    """Eq. 6."""
    image = records(planes[0] if len(planes) == 1 else np.ascontiguousarray(np.moveaxis(planes, 0, -1)))
    result = np.empty_like(image)
    factors = taps.astype(np.float32), weights.astype(np.float32)
    over_rows(_full_rows, image.shape[0], image, flow, *factors, sampling == "nearest", result)
    return np.ascontiguousarray(np.moveaxis(result, -1, 0))[: len(planes)]


@kernel
def _full_rows(
    first: int, last: int, image: Any, flow: Any, taps: Any, weights: Any, to_nearest: bool, result: Any
) -> None:
    height, width, channels = image.shape
    source, tangents, target = image.reshape(-1), flow.reshape(-1), result.reshape(-1)
    for y in range(first, last):
        _full_row(source, channels, tangents, taps, weights, to_nearest, y, width, height, target)


@kernel
def _full_row(
    image: Any,
    channels: int,
    flow: Any,
    taps: Any,
    weights: Any,
    to_nearest: bool,
    y: int,
    width: int,
    height: int,
    result: Any,
) -> None:
    walk = new_walk()
    centre_x, centre_y = scratch(np.float64, 1), scratch(np.float64, 1)
    dx, dy = scratch(np.float64, 1), scratch(np.float64, 1)
    between = new_between()
    values, total = scratch(np.float32, 4), scratch(np.float32, 4)
    for x in range(0, width, COLUMNS):
        block = Block(x, y, u(min(COLUMNS, width - x)), width, height)
        first, size = u(channels) * first_pixel(block), u(channels) * block.size
        for k in range(size):
            total[k] = np.float32(0.0)
        for way in range(2):
            start(walk, flow, way, block)
            for s in range(way, weights.size):  # the centre belongs to the first way
                if s > 0:
                    step(walk, flow, block)
                if to_nearest:  # z is the pixel itself
                    snap(walk.dx, walk.dy, centre_x, centre_y, block)
                else:
                    for i in range(block.size):
                        centre_x[i], centre_y[i] = walk.dx[i], walk.dy[i]
                for n in range(1 - taps.size, taps.size):
                    for i in range(block.size):
                        dx[i] = centre_x[i] + n * np.float64(walk.ty[i])
                        dy[i] = centre_y[i] - n * np.float64(walk.tx[i])
                    find(dx, dy, between, block)
                    read_between(image, between, values, block, channels)
                    weight = weights[u(s)] * taps[u(abs(n))]
                    for k in range(size):
                        total[k] += weight * values[k]
        for k in range(size):
            result[first + k] = total[k]
