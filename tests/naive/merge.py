"""Nuke's merge operations read plainly: a pixel's channels and alphas in float64."""

import numpy as np


def merge(operation, A, B, a, b):
    """Return the channels of A and B, arrays that broadcast with the alphas a and b, after an operation."""
    A, B, a, b = (np.asarray(each, np.float64) for each in (A, B, a, b))
    return {
        "over": A + B * (1 - a),
        "under": A * (1 - b) + B,
        "plus": A + B,
        "minus": A - B,
        "multiply": A * B,
        "screen": np.where((A >= 0) & (A <= 1) & (B >= 0) & (B <= 1), A + B - A * B, np.maximum(A, B)),
        "min": np.minimum(A, B),
        "max": np.maximum(A, B),
        "difference": np.abs(A - B),
        "mask": B * a,
        "stencil": B * (1 - a),
    }[operation]


def grade(rgb, alpha, exposure=0.0, gain=1.0, offset=0.0, gamma=1.0, saturation=1.0, weights=(0.2126, 0.7152, 0.0722)):
    """Return premultiplied rgb (..., 3) with alpha (..., 1) after a grade of the colours divided by alpha."""
    rgb, alpha = np.asarray(rgb, np.float64), np.asarray(alpha, np.float64)
    covered = alpha > 1e-20
    c = np.where(covered, rgb / np.where(covered, alpha, 1), rgb) * gain * 2.0**exposure
    graded = c + offset
    graded = np.where(graded > 0, np.power(np.maximum(graded, 0), 1 / gamma), graded)
    graded = np.where(covered, graded * alpha, c)
    luminance = (graded * np.asarray(weights)).sum(axis=-1, keepdims=True)
    return luminance + saturation * (graded - luminance)
