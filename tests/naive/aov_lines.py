"""Lines from passes, crack by crack and point by point, every point with every other, in float64."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]

OUTLINE, OBJECT, MATERIAL, CREASE, INTERSECTION = range(5)
HALF_MAX = 65504.0


def smoothstep(low: float, high: float, x: Any) -> Any:
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def affine(depth: npt.ArrayLike) -> Float64:
    """Return 1 / Z, 0 for the background, as float32 holds it."""
    z = np.asarray(depth, np.float64)
    solid = np.isfinite(z) & (z > 0) & (z < 1e9) & (z != HALF_MAX)
    return np.where(solid, 1 / np.where(solid, z, 1), 0).astype(np.float32).astype(np.float64)


def own_depth(u: Float64, ids: Any) -> Float64:
    """Replace u beside other ids where it is not within 2 % of the median of its own id, twice."""
    height, width = u.shape
    for _ in range(2):
        agreeing = u.copy()
        for y in range(height):
            for x in range(width):
                near = (slice(max(y - 1, 0), y + 2), slice(max(x - 1, 0), x + 2))
                own = np.sort(u[near][ids[near] == ids[y, x]])
                median, nearest = own[(len(own) - 1) // 2 if len(own) % 2 else len(own) // 2 - 1], own[-1]
                if len(own) < u[near].size and abs(u[y, x] - median) > 0.02 * abs(median):
                    agreeing[y, x] = nearest if nearest > u[y, x] + 0.02 * abs(nearest) else median
        u = agreeing
    return u


def own_material(material: Any, ids: Any) -> Any:
    """Give each pixel beside another id the material that most of its id have around it; ties keep their own."""
    agreeing = np.array(material)
    for y, x in np.ndindex(agreeing.shape):
        near = (slice(max(y - 1, 0), y + 2), slice(max(x - 1, 0), x + 2))
        others = ids[near] == ids[y, x]
        if others.all():
            continue
        found = [int(each) for each in material[near][others]]
        found.remove(int(material[y, x]))
        counts = {each: found.count(each) for each in found}
        if counts and max(counts.values()) > counts.get(int(material[y, x]), 0):
            agreeing[y, x] = next(each for each in found if counts[each] == max(counts.values()))
    return agreeing


def four(u: Float64, y: int, x: int, y1: int, x1: int) -> Any:
    """Return u of four pixels in a row, the border repeated."""
    height, width = u.shape
    before = u[max(2 * y - y1, 0), max(2 * x - x1, 0)]
    return before, u[y, x], u[y1, x1], u[min(2 * y1 - y, height - 1), min(2 * x1 - x, width - 1)]


def step(a: float, b: float, c: float, d: float) -> float:
    """Return J between b and c."""
    if b == c == 0:
        return 0.0
    if (b == 0 or c == 0) and max(b, c) >= 1 / HALF_MAX:
        a, b, c, d = (each or 1 / HALF_MAX for each in (a, b, c, d))
    tests = np.array([(2 * b - a) - c, b - (2 * c - d), b - c])
    agree = (tests > 0).all() or (tests < 0).all()
    return float(np.sign(tests[2]) * np.abs(tests).min() / max(abs(b), abs(c))) if agree else 0.0


def edges(depth: Any = None, ids: Any = None, material: Any = None, depth_step: float = 0.02) -> dict[str, Any]:
    """Return the points of the edges: x, y, nx, ny, strength, surface, depth, kind."""
    height, width = next(np.shape(each) for each in (depth, ids, material) if each is not None)
    u = None if depth is None else affine(depth)
    if u is not None and ids is not None:
        u = own_depth(u, ids)
    if material is not None and ids is not None:
        material = own_material(material, ids)
    cracks = []
    for y in range(height):
        for x in range(width):
            for y1, x1 in ((y + 1, x), (y, x + 1)):
                if y1 == height or x1 == width:
                    continue
                kind = None
                if ids is not None and ids[y, x] != ids[y1, x1]:
                    kind = "id"
                elif material is not None and material[y, x] != material[y1, x1]:
                    kind = "material"
                j = 0.0 if u is None else step(*four(u, y, x, y1, x1))
                if kind is None:
                    around = (slice(max(y - 1, 0), y1 + 2), slice(max(x - 1, 0), x1 + 2))
                    if abs(j) <= depth_step / 4 or (ids is not None and (ids[around] != ids[y, x]).any()):
                        continue
                    kind = "depth"
                names = material if kind == "material" else ids
                first, second = (0, 0) if names is None else (int(names[y, x]), int(names[y1, x1]))
                nearer, behind, depths = 0.0, 0, (0.0, 0.0)
                if u is not None:
                    a, b, c, d = four(u, y, x, y1, x1)
                    depths = b, c
                    nearer = (
                        float(np.clip(((3 * b - a) - (3 * c - d)) / 2 / (0.005 * max(b, c)), -1, 1)) if b or c else 0
                    )
                    behind = int(c == 0) - int(b == 0)
                if kind == "id" and 0 in (first, second):
                    behind = 1 if second == 0 else -1
                place = ((x + x1) / 2, (y + y1) / 2, x1 - x, y1 - y)
                cracks.append((place, kind, j, nearer, behind, (first, second), depths))
    points = [decide(crack, cracks, depth_step, u is not None) for crack in cracks]
    names = ("x", "y", "nx", "ny", "strength", "surface", "depth", "touching", "kind")
    return {name: np.array([point[k] for point in points]) for k, name in enumerate(names)}


def decide(crack: Any, cracks: Any, depth_step: float, has_depth: bool) -> Any:
    """Return the point of a crack: which side is near, how strong it is, and of which kind."""
    (x, y, dx, dy), kind, j, _, behind, (first, second), depths = crack
    steep = smoothstep(depth_step / 4, depth_step, abs(j))
    share, near, touching = 1.0, j > 0, 0.0
    if kind != "depth":
        pair = [each for each in cracks if each[1] == kind and set(each[5]) == {first, second}]
        alike = [1 if each[5] == (first, second) else -1 for each in pair]
        offsets = np.array([(each[0][0] - x, each[0][1] - y) for each in pair])
        squares = (offsets**2).sum(axis=1)
        w = np.exp(-squares / 18) * (squares <= 81)
        votes = np.array([each[3] for each in pair]) * alike
        steps = smoothstep(depth_step / 4, depth_step, np.abs([each[2] for each in pair]))
        towards = sum(each[3] * sign for each, sign in zip(pair, alike, strict=True) if each[4] == 0)
        tie = np.sign(towards) or (1 if first > second else -1)
        vote = (w * votes).sum() / w.sum()
        near = behind > 0 if behind else vote + 0.25 * tie >= 0
        if has_depth and not behind:
            touching = np.clip((0.95 - abs(towards) / len(pair)) / 0.15, 0, 1) * (1 - smoothstep(0, 1, abs(vote)))
        share = (w * steps).sum() / w.sum()
    side = 1 if near else -1
    if behind:
        made = OUTLINE
    elif has_depth and kind != "depth" and share < 0.5:
        made = INTERSECTION if kind == "id" else MATERIAL
    else:
        made = MATERIAL if kind == "material" and not has_depth else OBJECT
    own = 0 if near else 1
    strength = steep if kind == "depth" else 1.0
    return x, y, side * dx, side * dy, strength, (first, second)[own], depths[own], touching, made


def same_stroke(points: dict[str, Any], e: int) -> Any:
    u = points["depth"]
    near = np.abs(u - u[e]) <= 0.25 * np.maximum(np.abs(u), np.abs(u[e]))
    return (points["surface"] == points["surface"][e]) & near


def directed(points: dict[str, Any]) -> dict[str, Any]:
    """Return points whose directions are the means around them."""
    n = np.stack([points["nx"], points["ny"]], axis=1).astype(np.float64)
    mean = n.copy()
    for e in range(len(n)):
        dx, dy = points["x"] - points["x"][e], points["y"] - points["y"][e]
        counts = (dx**2 + dy**2 <= 16) & (n @ n[e] >= 0) & same_stroke(points, e)
        total = (counts * points["strength"] * np.exp(-(dx**2 + dy**2) / 4.5)) @ n
        mean[e] = total / np.hypot(*total) if total.any() else n[e]
    return points | {"nx": mean[:, 0], "ny": mean[:, 1]}


def fitted(points: dict[str, Any], sigma: float) -> dict[str, Any]:
    """Return points on the lines through them, by weighted least squares."""
    made = {name: np.array(points[name], np.float64) for name in ("x", "y", "nx", "ny", "strength", "touching")}
    n = np.stack([points["nx"], points["ny"]], axis=1)
    for e in range(len(n)):
        dx, dy = points["x"] - points["x"][e], points["y"] - points["y"][e]
        s, h, alike = dy * n[e, 0] - dx * n[e, 1], dx * n[e, 0] + dy * n[e, 1], n @ n[e]
        counts = (
            (alike >= 0.5)
            & (np.maximum(np.abs(dx), np.abs(dy)) <= 3 * sigma)
            & (np.abs(s) <= 3 * sigma)
            & (np.abs(h) <= 2)
            & same_stroke(points, e)
        )
        bend = (n[e, 0] * n[:, 1] - n[e, 1] * n[:, 0]) / np.where(counts, alike, 1)
        h = h + s * bend / 2
        g = counts * alike**2 * np.exp(-(s**2) / (2 * sigma**2))
        w = g * points["strength"]
        a = b = 0.0
        if w.sum() > 0:
            normal = np.array([[w.sum(), (w * s).sum()], [(w * s).sum(), (w * s * s).sum() + 0.25 * w.sum()]])
            a, b = np.linalg.solve(normal, [(w * h).sum(), (w * s * h).sum()])
        tangent = np.array([-n[e, 1], n[e, 0]])
        made["x"][e], made["y"][e] = points["x"][e] + a * n[e, 0], points["y"][e] + a * n[e, 1]
        made["nx"][e], made["ny"][e] = (n[e] - b * tangent) / np.hypot(1, b)
        whole = sigma * np.sqrt(2 * np.pi) * np.abs(n[e]).max()
        made["touching"][e] = (w * points["touching"]).sum() / w.sum() if w.sum() > 0 else 0
        mean = w.sum() / g.sum()
        made["strength"][e] = smoothstep(0.3, 0.7, mean) * smoothstep(0.25, 0.55, g.sum() / whole)
    return points | made


def between(points: dict[str, Any], width: float) -> dict[str, Any]:
    """Return points in the far side by half a line's width, at most a pixel, where the sides touch."""
    off = points["touching"] * min(width / 2, 1)
    return points | {"x": points["x"] + off * points["nx"], "y": points["y"] + off * points["ny"]}


def distance(points: dict[str, Any], height: int, width: int) -> tuple[Float64, Any]:
    """Return the signed distance of each pixel to the nearest point's line, 10 without any, and the point's index."""
    found, which = np.full((height, width), 10.0), np.full((height, width), -1)
    drawn = np.flatnonzero(points["strength"] > 0)
    for y in range(height):
        for x in range(width):
            dx, dy = points["x"][drawn] - x, points["y"][drawn] - y
            nx, ny = points["nx"][drawn], points["ny"][drawn]
            d, s = dx * nx + dy * ny, dy * nx - dx * ny
            square = d**2 + s**2 + (2 * (1 - points["strength"][drawn])) ** 2
            square[(d**2 + s**2 > 100) | (np.abs(s) > 0.75 + 0.7 * np.abs(d))] = np.inf
            if square.size and square.min() < np.inf:
                k = int(square.argmin())
                found[y, x], which[y, x] = d[k], drawn[k]
    return found, which


def silhouettes(
    depth: Any = None, ids: Any = None, material: Any = None, width: float = 1.5, step: float = 0.02, sigma: float = 2.0
) -> tuple[Float64, Float64]:
    """Return the ink of each kind, (5, H, W), and the signed distance, (H, W)."""
    height, across = next(np.shape(each) for each in (depth, ids, material) if each is not None)
    points = between(fitted(directed(edges(depth, ids, material, step)), sigma), width)
    d, which = distance(points, height, across)
    ink = np.zeros((5, height, across))
    for y, x in np.argwhere(which >= 0):
        e = which[y, x]
        covered = np.clip(min(d[y, x], width - d[y, x]) + 0.5, 0, 1)
        ink[points["kind"][e], y, x] = points["strength"][e] * covered
    return ink, d
