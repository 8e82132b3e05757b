"""Measure soft edges by the edge model, and what f lacks there, in float64."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from tests.naive import fdog as naive
from tests.naive.streamline import bilinear, curve, gaussian


def missing(code, flow, reach=7.0, amount=1.0, sigma_c=1.0, rho=0.99, color_weight=0.0, pre_blur=0.0):
    """Return, for (H, W) or (H, W, 3), what is to be added to the sums across the flow, of the same shape."""
    code, flow = np.asarray(code, np.float64), np.asarray(flow, np.float64)
    planes = code if code.ndim == 3 else code[..., None]
    weights = np.array([1.0, color_weight, color_weight][: planes.shape[2]])
    t, d, e = reach / 2, 8 / 7 * reach / 2, 16 / 7 * reach / 2
    blurred = naive.blur(planes, t)
    size = np.hypot(flow[..., 0], flow[..., 1])[..., None]
    tangent = np.divide(flow, size, out=np.zeros_like(flow), where=size > 0)
    normal = np.stack([tangent[..., 1], -tangent[..., 0]], -1)

    def gradient(p):
        """Return the gradient across the flow, p pixels away, of each channel times its weight."""
        one, other = ((p + side) * normal for side in (0.5, -0.5))
        return weights * (bilinear(blurred, *np.moveaxis(one, -1, 0)) - bilinear(blurred, *np.moveaxis(other, -1, 0)))

    here = gradient(0.0)
    m = np.maximum((here**2).sum(-1), 1e-6)
    after, before, beyond, behind = ((here * gradient(p)).sum(-1) for p in (d, -d, e, -e))
    l_after, l_before = (np.log(np.maximum(each, 0.01 * m) / m) for each in (after, before))
    q = np.minimum(l_after + l_before, -1e-3)
    variance = -d * d / q
    x = d / 2 * (l_after - l_before) / q
    contrast = np.sqrt(2 * np.pi * variance) * np.exp(np.minimum(x**2 / (2 * variance), 2))  # of g = 1
    blur_variance = np.maximum(variance - 0.25 - t * t, 0)

    finer = naive.smoothstep(0.8, 0.95, (variance - 0.25) / t**2)
    soft = 1 - naive.smoothstep(2, 20 / 7, np.sqrt(blur_variance) / t)
    third = np.sqrt(m) * contrast / np.sqrt(2 * np.pi) * t**3 / np.maximum(np.sqrt(variance), t) ** 3
    sure = naive.smoothstep(1.3, 2.1, third)
    peak = np.exp(np.minimum(x**2 / (2 * variance), 2))
    off = [
        np.abs(found / m - np.exp((x**2 - (x + p) ** 2) / (2 * variance))) / peak
        for found, p in ((beyond, e), (behind, -e))
    ]
    alone = 1 - naive.smoothstep(0.3, 0.6, np.maximum(*off))
    ahead, back = (bilinear(blurred, *np.moveaxis(side * t * tangent, -1, 0)) for side in (1, -1))
    bend = (weights * here * (ahead + back - 2 * blurred)).sum(-1) / t**2
    straight = 1 - naive.smoothstep(0.2, 0.4, np.abs(bend) / m * np.sqrt(variance))
    w = finer * soft * sure * alone * straight * ((here**2).sum(-1) > 1e-6) * amount

    def h(v):
        """Return f's answer to a step of 1 whose blur has the variance v."""
        return ndtr(x / np.sqrt(v + sigma_c**2)) - rho * ndtr(x / np.sqrt(v + 2.56 * sigma_c**2))

    present = blur_variance + pre_blur**2
    share = w * contrast * (h(np.minimum(present, min(pre_blur, sigma_c) ** 2)) - h(present))
    one, other = (side * 0.5 * normal for side in (1, -1))
    plain = bilinear(blurred, *np.moveaxis(one, -1, 0)) - bilinear(blurred, *np.moveaxis(other, -1, 0))
    return _along(plain * share[..., None], flow, t).reshape(code.shape)


def _along(planes, flow, sigma):
    """Blur along the flow, by every n-th sample, their weights of the same sum and variance."""
    steps = int(np.ceil(3 * sigma))
    weights = gaussian(sigma, steps)
    every = max(1, round(sigma / 2))
    offsets = np.arange(-steps, steps + 1)
    variance = (weights * offsets**2).sum()
    weights[offsets % every > 0] = 0
    weights *= variance / (weights * offsets**2).sum()
    weights[steps] += 1 - weights.sum()
    total = weights[steps] * planes
    for way in (1, -1):
        for s, (dx, dy, _) in enumerate(curve(flow, steps, way), 1):
            total = total + weights[steps + way * s] * bilinear(planes, dx, dy)
    return total
