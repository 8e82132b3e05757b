"""Creases of normals, row by row and column by column, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def unit_normals(normal: npt.ArrayLike) -> Any:
    """Return normals at length 1, 0 where they are not finite or shorter than a half."""
    n = np.asarray(normal, np.float64)
    size = np.linalg.norm(n, axis=2, keepdims=True)
    there = np.isfinite(size) & (size >= 0.5)
    return np.where(there, n / np.where(there, size, 1), 0)


def find_creases(unit: Any, theta: float, h: float) -> Any:
    """Return x, y, |nx|, |ny|, strength and excess of each peak, in order of rows, then x."""
    found = along_rows(unit, theta, h)
    found += [(y, x, ny, nx, *rest) for x, y, nx, ny, *rest in along_rows(np.swapaxes(unit, 0, 1), theta, h)]
    return np.array(sorted(found, key=lambda each: (np.floor(each[1]), each[0]))).reshape(-1, 6)


def along_rows(unit: Any, theta: float, h: float) -> list[Any]:
    height, width = unit.shape[:2]
    found = []
    for y in range(height):
        turn = {k: angle(at(unit[y], k - h), at(unit[y], k + h)) for k in np.arange(-0.5, width + 0.5)}
        for x in range(width - 1):
            k = x + 0.5
            before, middle, after = turn[k - 1], turn[k], turn[k + 1]
            beside = angle(at(unit[y], k - 3 * h), at(unit[y], k - h)) + angle(
                at(unit[y], k + h), at(unit[y], k + 3 * h)
            )
            excess = middle - beside / 2
            s = max(h, 1)
            near = sum(angle(at(unit[y], k + c - h), at(unit[y], k + c + h)) for c in (-s, s))
            sudden = min(middle, 2 * middle - near)
            if middle <= theta / 2 or before > middle or after >= middle:
                continue
            strength = smoothstep(theta / 2, theta, sudden) * smoothstep(0.4 * theta, 0.8 * theta, excess)
            if strength == 0:
                continue
            curved = before - 2 * middle + after
            offset = (before - after) / 2 / curved if curved < -1e-6 else 0.0
            nx, ny = across(unit, x, y)
            if abs(nx) >= 0.4:
                found.append((k + offset, y, abs(nx), abs(ny), strength, excess))
    return found


def smoothstep(low: float, high: float, x: float) -> float:
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)


def at(row: Any, x: float) -> Any:
    """Return the normal at x, between pixels a mean of two, beyond the ends the last one."""
    x = min(max(x, 0), len(row) - 1)
    i = int(x)
    return row[i] + (x - i) * (row[min(i + 1, len(row) - 1)] - row[i])


def angle(a: Any, b: Any) -> float:
    size = (a @ a) * (b @ b)
    return float(np.degrees(np.arccos(np.clip(a @ b / np.sqrt(size), -1, 1)))) if size >= 0.01 else 0.0


def across(unit: Any, x: int, y: int) -> Any:
    """Return the major eigenvector of the tensor of both pixels' gradients together."""
    padded = np.pad(unit, ((1, 1), (1, 1), (0, 0)), "edge")
    sobel = np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]])
    g = 0
    for i in (x, x + 1):
        around = padded[y : y + 3, i : i + 3]
        g = g + np.stack([np.tensordot(sobel, around), np.tensordot(sobel.T, around)])
    return np.linalg.eigh(g @ g.T)[1][:, 1]
