"""Smooth with the bilateral filters that the paper compares itself with (Figs. 16-21), in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.fbl import _bilateral


def bilateral(codes, sigma_d, sigma_r, iterations, kernel="full", alpha=None):
    """Smooth codes (H, W, 3) over the square ("full", Tomasi and Manduchi), or in x, then y (Pham and van Vliet).

    The border is repeated.
    """
    codes = np.asarray(codes, np.float64)
    alpha = np.ones(codes.shape[:2]) if alpha is None else np.asarray(alpha, np.float64)
    steps = int(np.ceil(3 * sigma_d))
    reach = range(-steps, steps + 1)
    windows = {
        "full": [[(dx, dy) for dx in reach for dy in reach]],
        "xy": [[(dx, 0) for dx in reach], [(0, dy) for dy in reach]],
    }
    for _ in range(iterations):
        for window in windows[kernel]:
            codes = _mean(codes, alpha, window, steps, sigma_d, sigma_r)
    return codes


def _mean(codes, alpha, window, steps, sigma_d, sigma_r):
    """Return the weighted mean over the offsets (dx, dy) of ``window``, at most ``steps`` pixels away."""
    height, width = alpha.shape
    wide = np.pad(codes, ((steps, steps), (steps, steps), (0, 0)), "edge")
    wide_alpha = np.pad(alpha, steps, "edge")
    total, weight = np.zeros_like(codes), np.zeros_like(alpha)
    for dx, dy in window:
        rows, columns = slice(steps + dy, steps + dy + height), slice(steps + dx, steps + dx + width)
        colour = wide[rows, columns]
        w = wide_alpha[rows, columns] * np.exp(-((codes - colour) ** 2).sum(-1) / (2 * sigma_r**2))
        w = w * np.exp(-(dx**2 + dy**2) / (2 * max(sigma_d, 1e-6) ** 2))
        total, weight = total + w[..., None] * colour, weight + w
    return np.where(alpha[..., None] > 0, total / np.where(weight > 0, weight, 1)[..., None], codes)


def curvature(flow):
    """Return kappa = n . (t . grad) t with n = (-t.y, t.x), by central differences of tangents that agree with t."""
    t = np.asarray(flow, np.float64)
    wide = np.pad(t, ((1, 1), (1, 1), (0, 0)), "edge")

    def agreeing(there):
        return np.where((there * t).sum(-1, keepdims=True) < 0, -there, there)

    along_x = (agreeing(wide[1:-1, 2:]) - agreeing(wide[1:-1, :-2])) / 2
    along_y = (agreeing(wide[2:, 1:-1]) - agreeing(wide[:-2, 1:-1])) / 2
    change = t[..., :1] * along_x + t[..., 1:] * along_y
    return t[..., 0] * change[..., 1] - t[..., 1] * change[..., 0]


def bilateral_oriented(
    codes, flow, sigma_e, r_e, sigma_g, r_g, iterations, kernel="line", sampling="nearest", alpha=None
):
    """Smooth like FBL, but along a straight line or a parabola in place of the streamline."""
    codes, flow = np.asarray(codes, np.float64), np.asarray(flow, np.float64)
    alpha = np.ones(codes.shape[:2]) if alpha is None else np.asarray(alpha, np.float64)
    t, n = flow, np.stack([-flow[..., 1], flow[..., 0]], -1)
    bend = curvature(flow) if kernel == "arc" else np.zeros(flow.shape[:2])

    def reach(sigma):
        steps = int(np.ceil(3 * sigma))
        return [s for s in range(-steps, steps + 1) if s != 0]

    for _ in range(iterations):
        points = [(s, s * t + (bend * s**2 / 2)[..., None] * n) for s in reach(sigma_e)]
        path = [(s, point[..., 0], point[..., 1]) for s, point in points]
        codes = _bilateral(codes, alpha, path, sigma_e, r_e, sampling)
        path = [(s, -s * n[..., 0], -s * n[..., 1]) for s in reach(sigma_g)]
        codes = _bilateral(codes, alpha, path, sigma_g, r_g, sampling)
    return codes
