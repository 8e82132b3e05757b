"""Detect lines by difference of Gaussians, isotropic and flow-based (section 3), in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.streamline import Float64, along, bilinear, centres, curve, gaussian


def taps(sigma_c: float, rho: float) -> Float64:
    """Return f at -T .. T."""
    steps = surround(sigma_c)
    return gaussian(sigma_c, steps) - rho * gaussian(1.6 * sigma_c, steps)  # eq. 8


def surround(sigma_c: float) -> int:
    """Return T = ceil(3 * 1.6 sigma_c), rounded first: 3 * 1.6 * 5 is 24.000000000000004 in floating point."""
    return int(np.ceil(np.round(3 * 1.6 * sigma_c, 9)))


def across(image: Float64, t: Float64, f: Float64, dx: Float64 | float = 0, dy: Float64 | float = 0) -> Float64:
    """Sum over the gradient axes through the points (dx, dy) away from each pixel, perpendicular to t."""
    steps = f.size // 2
    zero = np.zeros(image.shape)
    return sum(
        f[n + steps] * bilinear(image, zero + dx + n * t[..., 1], zero + dy - n * t[..., 0])  # eq. 10
        for n in range(-steps, steps + 1)
    )


def fdog(
    code,
    flow,
    sigma_m=3.0,
    sigma_c=1.0,
    rho=0.99,
    color_weight=0.0,
    kernel="separable",
    sampling="bilinear",
    color_sign=False,
    evidence=0.0,
    missing=0.0,
    lone_lines=0.0,
):
    """Return H by eqs. 10 and 11 ("separable") or eq. 6 ("full"); of (H, W, 3) also with the responses of colour.

    ``missing``, a number or of the shape of the code, is added to the sums across the flow.
    """
    if evidence > 0 or lone_lines > 0:
        h = fdog(code, flow, sigma_m, sigma_c, rho, color_weight, kernel, sampling, color_sign, missing=missing)
        return by_evidence(h, np.asarray(flow, np.float64), sigma_m, evidence, lone_lines)
    code, flow = np.asarray(code, np.float64), np.asarray(flow, np.float64)
    if code.ndim == 3:
        lack = np.broadcast_to(missing, code.shape)
        d = [
            fdog(code[..., k], flow, sigma_m, sigma_c, rho, 0, kernel, sampling, missing=lack[..., k]) for k in range(3)
        ]
        if color_weight == 0:
            return d[0]
        return _joined(d[0], color_weight * d[1], color_weight * d[2], color_sign)
    f = taps(sigma_c, rho)
    if kernel == "separable":
        return along(across(code, flow, f) + missing, flow, sigma_m, sampling)
    steps = int(np.ceil(3 * sigma_m))
    weights = gaussian(sigma_m, steps)
    total = weights[steps] * across(code, flow, f)
    for way in (1, -1):
        for s, (dx, dy, t) in enumerate(curve(flow, steps, way), 1):
            if sampling == "nearest":
                x, y = centres(code.shape)
                dx = np.clip(x + np.rint(dx), 0, code.shape[1] - 1) - x
                dy = np.clip(y + np.rint(dy), 0, code.shape[0] - 1) - y
            total = total + weights[steps + way * s] * across(code, t, f, dx, dy)  # eq. 6
    return total + along(np.broadcast_to(missing, code.shape), flow, sigma_m, sampling)


def _joined(d_l: Float64, m_a: Float64, m_b: Float64, color_sign: bool) -> Float64:
    """Join the responses of lightness and of two channels of colour, which are weighted already."""
    m_c = np.hypot(m_a, m_b)
    sign = np.tanh(2 * d_l)
    if color_sign:
        t = np.where(m_c > 0, smoothstep(0.1, 0.3, np.abs(d_l) / np.where(m_c > 0, m_c, 1)), 1)
        sign = t * sign + (1 - t) * np.tanh(2 * (0.4 * m_a + 0.7 * m_b))
        q = smoothstep(1, 2, m_c)
        sign = (1 - q) * sign + q * (2 * smoothstep(0, 1, sign) - 1)
    return np.hypot(d_l, m_c) * sign


def by_evidence(h: Float64, flow: Float64, sigma_m: float, evidence: float, lone: float = 0.0) -> Float64:
    """Return H, where it is below 0 weaker if little ink lies along a longer stretch, stronger if little is around."""
    n = np.maximum(-h, 0)
    b = along(n, flow, 3 * sigma_m, "nearest")
    a = blur(n, 3 * sigma_m)
    gain = 1 + lone * np.maximum(1 - a / (0.3 * np.maximum(b, 1e-6)), 0) / (1 + a / 0.1)
    return np.where(h < 0, -np.minimum(n, n ** (1 - evidence / 2) * b ** (evidence / 2)) * gain, h)


def smoothstep(low: float, high: float, x: Float64) -> Float64:
    """Return 0 up to ``low``, 1 from ``high`` on, and a smooth way between."""
    x = np.clip((x - low) / (high - low), 0, 1)
    return 3 * x**2 - 2 * x**3


def threshold(response, tau=0.5, contrast=None, softness=0.0):
    """Draw lines by eq. 9 as printed; with a contrast or softness, as docs/numbers.md says."""
    response = np.asarray(response, np.float64)
    if contrast is None and softness == 0:
        return np.where((response < 0) & (1 + np.tanh(response) < tau), 0.0, 1.0)  # eq. 9
    c = -np.arctanh(tau - 1) if contrast is None else contrast
    if softness == 0:
        return np.where(response < -c, 0.0, 1.0)
    x = np.clip((response + c + softness) / softness, 0, 1)
    return 3 * x**2 - 2 * x**3


def fdog_iterative(
    code,
    flow,
    iterations,
    pre_blur=0.0,
    tau=0.5,
    contrast=None,
    softness=0.0,
    evidence=0.0,
    lone_lines=0.0,
    **parameters,
):
    """Draw lines by section 3.2: each pass filters the picture with the last pass's ink over it."""
    code = np.asarray(code, np.float64)
    image = code
    for each in range(iterations):
        e, lone = (evidence, lone_lines) if each == iterations - 1 else (0, 0)
        response = fdog(blur(image, pre_blur), flow, evidence=e, lone_lines=lone, **parameters)
        lines = threshold(response, tau, contrast, softness)
        image = code * (lines if code.ndim == 2 else lines[..., None])
    return lines, response


def blur(image, sigma, steps=None):
    """Blur by weighted sums over columns, then rows, border repeated."""
    steps = int(np.ceil(3 * sigma)) if steps is None else steps
    weights = gaussian(sigma, steps)
    result = np.asarray(image, np.float64)
    for axis in (0, 1):
        padding = [(0, 0)] * result.ndim
        padding[axis] = (steps, steps)
        padded = np.pad(result, padding, "edge")
        result = sum(
            weights[k] * np.take(padded, np.arange(k, k + result.shape[axis]), axis) for k in range(weights.size)
        )
    return result


def dog(code, sigma_c, rho):
    """Return the response of the isotropic DoG: eq. 8 in two dimensions."""
    steps = surround(sigma_c)
    return blur(code, sigma_c, steps) - rho * blur(code, 1.6 * sigma_c, steps)
