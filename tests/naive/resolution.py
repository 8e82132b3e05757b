"""Reduce pictures and bring results up, pixel by pixel, in float64."""

from __future__ import annotations

import numpy as np


def reduced(picture, factor, weights=None):
    """Return the (weighted) mean of each block; the border is repeated until the picture is whole blocks."""
    picture = np.asarray(picture, np.float64)
    height, width = picture.shape[:2]
    weights = np.ones((height, width)) if weights is None else np.asarray(weights, np.float64)
    result = np.zeros((-(-height // factor), -(-width // factor), *picture.shape[2:]))
    for j, i in np.ndindex(*result.shape[:2]):
        rows = np.minimum(range(factor * j, factor * (j + 1)), height - 1)
        columns = np.minimum(range(factor * i, factor * (i + 1)), width - 1)
        share = weights[np.ix_(rows, columns)]
        if share.sum() > 0:
            result[j, i] = np.tensordot(share, picture[np.ix_(rows, columns)], 2) / share.sum()
    return result


def cubic(distance):
    """Return the weight of a sample so far away: Keys' kernel, a = -1/2."""
    d = abs(distance)
    if d < 1:
        return 1.5 * d**3 - 2.5 * d**2 + 1
    return -0.5 * d**3 + 2.5 * d**2 - 4 * d + 2 if d < 2 else 0.0


def linear(distance):
    """Return the weight of a sample so far away: a tent."""
    return max(1 - abs(distance), 0.0)


def enlarged(plane, factor, height, width, kernel=cubic):
    """Return a plane (h, w) read at every pixel of the full size, its border repeated."""
    plane = np.asarray(plane, np.float64)

    def along(count, size):
        weights = np.zeros((count, size))
        for pixel in range(count):
            place = (pixel + 0.5) / factor - 0.5
            for sample in range(int(np.floor(place)) - 1, int(np.floor(place)) + 3):
                weights[pixel, min(max(sample, 0), size - 1)] += kernel(place - sample)
        return weights

    return along(height, plane.shape[0]) @ plane @ along(width, plane.shape[1]).T


def angles(flow):
    """Return cos 2θ and sin 2θ of each tangent, as planes; 0 where there is none."""
    angle = np.arctan2(*np.moveaxis(np.asarray(flow, np.float64), -1, 0)[::-1])
    there = (flow != 0).any(-1)
    return np.cos(2 * angle) * there, np.sin(2 * angle) * there


def upsampled(codes, small, smoothed, factor, covered=None):
    """Return a x + b of each channel: the line fitted to 3 x 3 reduced pixels, brought up linearly; eps is 10."""
    height, width = small.shape[:2]
    weights = np.ones((height, width)) if covered is None else np.asarray(covered, np.float64)
    result = np.empty(codes.shape)
    for c in range(3):
        slope, offset = np.zeros((height, width)), np.zeros((height, width))
        for j, i in np.ndindex(height, width):
            around = np.ix_(
                np.clip(range(j - 1, j + 2), 0, height - 1),
                np.clip(range(i - 1, i + 2), 0, width - 1),
            )
            x, z, w = (np.asarray(each, np.float64)[around] for each in (small[..., c], smoothed[..., c], weights))
            if w.sum() == 0:
                offset[j, i] = smoothed[j, i, c]
                continue
            mean_x, mean_z = (np.average(each, weights=w) for each in (x, z))
            variance = np.average((x - mean_x) ** 2, weights=w)
            slope[j, i] = np.clip(np.average((x - mean_x) * (z - mean_z), weights=w) / (variance + 10), -4, 4)
            offset[j, i] = mean_z - slope[j, i] * mean_x
        a, b = (enlarged(each, factor, *codes.shape[:2], linear) for each in (slope, offset))
        result[..., c] = a * codes[..., c] + b
    return result
