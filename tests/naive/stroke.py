"""Narrow strokes by their length and their ends, for all pixels at once, in float64."""

from __future__ import annotations

import numpy as np

from tests.naive.fdog import blur, smoothstep
from tests.naive.streamline import Float64, bilinear, nearest


def stroke(lines, flow, min_length=0.0, taper=0.0, strength=0.0, response=None):
    """Return the drawing with strokes narrowed."""
    lines, flow = np.asarray(lines, np.float64), np.asarray(flow, np.float64)
    ink = np.clip(1 - lines, 0, 1)
    longest = max(min_length, taper)
    one, other = (walk(ink, flow, way, longest, int(np.ceil(max(1.5 * min_length, taper)))) for way in (1, -1))
    width = np.ones(ink.shape)
    if min_length > 0:
        width *= smoothstep(0.5, 1.5, (one + other + 1) / min_length)
    if taper > 0:
        u = np.minimum((np.minimum(one, other) + 0.5) / taper, 1)
        width *= u * (2 - u)
    if strength > 0:
        width *= np.clip(-np.asarray(response, np.float64) / strength, 0, 1)
    reach = int(np.ceil(max(longest / 2, 16)))
    sides = [across(ink, flow, way, reach) for way in (1, -1)]
    whole, off = sum(sides) + ink, abs(sides[0] - sides[1]) / 2
    middle = np.where((ink >= 1 / 64) & (off <= np.maximum(0.55 * whole / 2, 0.6)), ink, 0)
    sigma = max(0.1 * longest, 1.5)
    around = blur(middle, sigma)
    width = np.where(around > 0, blur(width * middle, sigma) / np.where(around > 0, around, 1), 1)
    share = np.clip(width * (whole / 2 + 1) - off, 0, 1)
    return np.where(ink > 0, lines * share + 1 - share, lines)


def walk(ink: Float64, flow: Float64, way: int, longest: float, steps: int) -> Float64:
    """Return how much ink of its stroke lies one way of each pixel."""
    fade = 1 - np.exp(-5 / longest) if longest > 0 else 1
    dx, dy = np.zeros(ink.shape), np.zeros(ink.shape)
    survival, total, t = np.ones(ink.shape), np.zeros(ink.shape), way * flow
    for _ in range(steps):
        dx, dy = dx + t[..., 0], dy + t[..., 1]
        nx, ny = t[..., 1], -t[..., 0]
        aside = (bilinear(ink, dx + nx, dy + ny) - bilinear(ink, dx - nx, dy - ny)) / 2
        dx, dy = dx + aside * nx, dy + aside * ny
        q = np.minimum(2 * bilinear(ink, dx, dy), 1)
        survival = survival * (1 - fade * (1 - q))
        survival[survival < 1 / 64] = 0
        total = total + survival * q
        there = nearest(flow, dx, dy)
        t = np.where((there * t).sum(-1, keepdims=True) < 0, -there, there)
    return total


def across(ink: Float64, flow: Float64, way: int, reach: int) -> Float64:
    """Return how much ink lies between each pixel and the paper on one side of its line."""
    survival, total = np.ones(ink.shape), np.zeros(ink.shape)
    for s in range(1, reach + 1):
        q = bilinear(ink, way * s * flow[..., 1], -way * s * flow[..., 0])
        survival = np.minimum(survival, 2 * q)
        survival[survival < 1 / 64] = 0
        total = total + survival * q
    return total
