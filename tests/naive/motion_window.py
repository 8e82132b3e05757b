"""A mean over a window of frames along the motion, pixel by pixel, in float64."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Frames = Mapping[int, npt.ArrayLike]

LOST = (math.nan, math.nan)


def motion_window(
    images: Frames,
    motions: Frames,
    guides: Frames | None = None,
    depths: Frames | None = None,
    normals: Frames | None = None,
    alphas: Frames | None = None,
    *,
    reach: int = 2,
    falloff: str = "gaussian",
    agreement: float = 8.0,
    consistency: float = 1.0,
    depth_tolerance: float = 0.05,
    normal_tolerance: float = 26.0,
) -> tuple[Float64, Float64]:
    """Return the mean, of the shape of ``images[0]``, and the confidence (H, W); guides are not blurred."""
    given = [frames for frames in (images, motions, guides, depths, normals, alphas) if frames is not None]
    offsets = [
        side * k
        for side in (1, -1)
        for k in range(1, reach + 1)
        if all(side * j in frames for frames in given for j in range(1, k + 1))
    ]
    frames = {
        k: {
            "image": np.asarray(images[k], np.float64),
            "motion": pure_motion(motions[k], None if depths is None else depths[k]),
            "guide": None if guides is None else np.asarray(guides[k], np.float64),
            "depth": None if depths is None else known(depths[k]),
            "normal": None if normals is None else np.asarray(normals[k], np.float64),
            "alpha": np.ones(np.shape(images[0])[:2]) if alphas is None else np.asarray(alphas[k], np.float64),
        }
        for k in (0, *offsets)
    }
    gauss = {k: math.exp(-k * k / (2 * reach * reach)) if falloff == "gaussian" else 1.0 for k in range(1, reach + 1)}
    own = frames[0]
    height, width = own["image"].shape[:2]
    mean, confidence = own["image"].copy(), np.zeros((height, width))
    flow = mean.ndim == 3 and mean.shape[2] == 2
    for y in range(height):
        for x in range(width):
            value = as_tensor(own["image"][y, x]) if flow else own["image"][y, x]
            total, weights = own["alpha"][y, x] * value, own["alpha"][y, x]
            found = 0.0
            place = (float(x), float(y))
            for k in offsets:
                if abs(k) == 1:
                    place = (float(x), float(y))
                place = step(frames, place, k, consistency, width, height)
                if not math.isnan(place[0]) and not same_surface(
                    own, frames[k], x, y, place, depth_tolerance * abs(k), normal_tolerance
                ):
                    place = LOST
                if math.isnan(place[0]):
                    continue
                weight = gauss[abs(k)]
                if own["guide"] is not None:
                    change = sample(frames[k]["guide"], place) - own["guide"][y, x]
                    weight *= math.exp(-change * change / (2 * agreement * agreement))
                found += weight
                alpha = frames[k]["alpha"]
                there = as_tensor(frames[k]["image"]) if flow else frames[k]["image"]
                total = total + weight * sample((there.T * alpha.T).T, place)
                weights += weight * sample(alpha, place)
            if weights > 0:
                average = total / weights
                mean[y, x] = major_axis(average, own["image"][y, x]) if flow else average
            confidence[y, x] = found / (2 * sum(gauss.values())) if gauss else 0
    return mean, confidence


def step(frames: Any, place: tuple[float, float], k: int, consistency: float, width: int, height: int) -> Any:
    """Return where a place on the frame before k, seen from frame 0, goes on frame k; LOST where that is nowhere."""
    if math.isnan(place[0]):
        return LOST
    near, far = frames[k - 1 if k > 0 else k + 1]["motion"], frames[k]["motion"]
    dx, dy = read_motion(near, place, k > 0)
    there = (place[0] + dx, place[1] + dy)
    if not (0 <= there[0] <= width - 1 and 0 <= there[1] <= height - 1):
        return LOST
    bx, by = read_motion(far, there, k < 0)
    return there if math.hypot(there[0] + bx - place[0], there[1] + by - place[1]) <= consistency else LOST


def read_motion(motion: Float64, place: tuple[float, float], to_next: bool) -> tuple[float, float]:
    """Return the step at a place, y down: bilinear where the four pixels around move alike, else the nearest one's."""
    steps = np.stack([-motion[..., 2], motion[..., 3]] if to_next else [motion[..., 0], -motion[..., 1]], axis=2)
    (x0, y0), (u, v) = corner(place, steps.shape)
    around = steps[y0 : y0 + 2, x0 : x0 + 2].reshape(-1, 2)
    if np.isfinite(around).all() and np.ptp(around, axis=0).max() <= 1.5:
        return tuple(sample(steps, place))
    return tuple(steps[y0 + (v >= 0.5), x0 + (u >= 0.5)])


def same_surface(own: Any, there: Any, x: int, y: int, place: Any, tolerance: float, degrees: float) -> bool:
    """Return whether one of the four pixels around a place has the depth and the normal of the pixel x, y."""
    (x0, y0), _ = corner(place, own["image"].shape)
    height, width = own["image"].shape[:2]

    def same(near: tuple[int, int]) -> bool:
        if own["depth"] is not None:
            a, b = own["depth"][y, x], there["depth"][near]
            if abs(a - b) > tolerance * min(abs(a), abs(b)):
                return False
        if own["normal"] is not None:
            n, m = own["normal"][y, x], there["normal"][near]
            return bool(n @ m >= math.cos(math.radians(degrees)) * np.linalg.norm(n) * np.linalg.norm(m))
        return True

    return any(same((min(y0 + j, height - 1), min(x0 + i, width - 1))) for j in range(2) for i in range(2))


def corner(place: tuple[float, float], shape: tuple[int, ...]) -> tuple[tuple[int, int], tuple[float, float]]:
    """Return the pixel up and left of a place, one before the last at most, and the distances from it."""
    last_x, last_y = max(shape[1] - 2, 0), max(shape[0] - 2, 0)
    x0, y0 = min(int(place[0]), last_x), min(int(place[1]), last_y)
    return (x0, y0), (place[0] - x0, place[1] - y0)


def sample(array: Float64, place: tuple[float, float]) -> Any:
    """Return an array (H, W, ...) at a place, bilinear."""
    (x0, y0), (u, v) = corner(place, array.shape)
    x1, y1 = min(x0 + 1, array.shape[1] - 1), min(y0 + 1, array.shape[0] - 1)
    upper = (1 - u) * array[y0, x0] + u * array[y0, x1]
    return (1 - v) * upper + v * ((1 - u) * array[y1, x0] + u * array[y1, x1])


def known(depth: npt.ArrayLike) -> Float64:
    """Return depths with 1e10 for all that is background."""
    z = np.asarray(depth, np.float64)
    return np.where(z < 1e9, z, 1e10)


def pure_motion(motion: npt.ArrayLike, depth: npt.ArrayLike | None) -> Float64:
    """Return motion with that of mixed pixels taken from the best pure one within 3 pixels."""
    result = np.array(motion, np.float64)
    if depth is None:
        return result
    z = known(depth)
    padded = np.pad(z, 1, mode="edge")
    around = np.stack([padded[j : j + z.shape[0], i : i + z.shape[1]] for j in range(3) for i in range(3)])
    mixed = (around.max(axis=0) > 1.03 * z) | (z > 1.03 * around.min(axis=0))
    before = result.copy()
    for y, x in np.argwhere(mixed):
        prices = {
            (v, u): 100 * abs(z[v, u] - z[y, x]) / max(abs(z[y, x]), 1e-20) + 0.05 * ((u - x) ** 2 + (v - y) ** 2)
            for v in range(max(y - 3, 0), min(y + 4, z.shape[0]))
            for u in range(max(x - 3, 0), min(x + 4, z.shape[1]))
            if not mixed[v, u]
        }
        if prices:
            result[y, x] = before[min(prices, key=lambda place: prices[place])]
    return result


def as_tensor(tangent: Float64) -> Float64:
    """Return xx, xy and yy of tangents (..., 2)."""
    x, y = tangent[..., 0], tangent[..., 1]
    return np.stack([x * x, x * y, y * y], axis=-1)


def major_axis(tensor: Float64, like: Float64) -> Float64:
    """Return the unit major eigenvector of a tensor, with the sign of a tangent."""
    xx, xy, yy = tensor
    values, vectors = np.linalg.eigh([[xx, xy], [xy, yy]])
    if np.isclose(values[0], values[1], rtol=1e-12, atol=0) or values[1] == 0:
        return like
    axis = vectors[:, 1]
    return axis if axis @ like >= 0 else -axis
