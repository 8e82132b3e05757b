"""Measure Fig. 23, time against kernel radius: ``python -m tools.gallery.speed [--json FILE] [--svg FILE]``.

ETF, FDoG and FBL on a 512x512 RGB picture, beside the bilateral filter, full and separable. "Kernel radius" is mu for
ETF, alpha = beta for FDoG and FBL, and half the window for the bilateral filter. Each radius runs once per round, in
another order in each, so that whatever else the machine does meets all of them. Counted is the processor's time on one
thread, the least of a radius' rounds; a straight line is fitted to those, and R^2 says how linear in the radius it is.
"""

from __future__ import annotations

import argparse
import json
import math
import platform
import random
import statistics
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.simd import bands

RADII = tuple(range(2, 21, 2))


class Case(NamedTuple):
    """A filter as a function of its kernel radius."""

    name: str
    color: str
    run: Callable[[int], object]


class Line(NamedTuple):
    """The straight line through a filter's times, in seconds."""

    intercept: float
    slope: float
    r2: float


def cases(size: int) -> list[Case]:
    """Return the filters of Fig. 23 on a picture of smooth shapes: each alone, with the flow computed beforehand."""
    noise = np.random.default_rng(23).normal(0, 1, (size, size, 3)).astype(np.float32)
    codes = 128 + 900 * filters.blur(noise, 4.0)
    code = np.ascontiguousarray(codes[..., 0])
    flow = filters.etf(code)
    return [
        Case("ETF (3 iterations)", "#1b6ca8", lambda r: filters.etf(code, radius=r)),
        Case("FDoG", "#c0392b", lambda r: filters.fdog(code, flow, sigma_m=_sigma(r), sigma_c=_sigma(r) / 1.6)),
        Case(
            "FBL (1 iteration)",
            "#1e8449",
            lambda r: filters.fbl(codes, flow, _sigma(r), 10.0, _sigma(r), 10.0, iterations=1),
        ),
        Case(
            "bilateral, separable", "#8e6bb0", lambda r: filters.bilateral(codes, _sigma(r), iterations=1, kernel="xy")
        ),
        Case("bilateral, full", "#777777", lambda r: filters.bilateral(codes, _sigma(r), iterations=1)),
    ]


def measure(size: int = 512, radii: Sequence[int] = RADII, repeats: int = 15) -> dict[str, Any]:
    """Return times (seconds, by filter and radius) and fits of all filters, as :func:`main` writes them."""
    with bands.limited(1):
        shown = cases(size)
        for case in shown:
            case.run(min(radii))  # compiles, or reads what was compiled
        todo = [(case, radius) for case in shown for radius in radii]
        seconds: dict[tuple[str, int], list[float]] = {(case.name, radius): [] for case, radius in todo}
        order = random.Random(23)
        for _ in range(repeats):
            order.shuffle(todo)
            for case, radius in todo:
                begin = time.process_time()
                case.run(radius)
                seconds[case.name, radius].append(time.process_time() - begin)
    found: dict[str, Any] = {}
    for case in shown:
        runs = [seconds[case.name, radius] for radius in radii]
        least = [min(run) for run in runs]
        found[case.name] = {
            "color": case.color,
            "min": least,
            "median": [statistics.median(run) for run in runs],
            "line": fit(radii, least)._asdict(),
        }
    return {
        "picture": f"{size}x{size} RGB",
        "machine": f"{platform.machine()}, Python {platform.python_version()}, numba {numba.__version__}",
        "repeats": repeats,
        "radii": list(radii),
        "filters": found,
    }


def fit(radii: Sequence[float], seconds: Sequence[float]) -> Line:
    """Fit a line by least squares; R^2 is 1 where all times are the same."""
    x, y = np.asarray(radii, np.float64), np.asarray(seconds, np.float64)
    slope = ((x - x.mean()) * (y - y.mean())).sum() / ((x - x.mean()) ** 2).sum()
    intercept = y.mean() - slope * x.mean()
    spread = ((y - y.mean()) ** 2).sum()
    left = ((y - intercept - slope * x) ** 2).sum()
    return Line(float(intercept), float(slope), float(1 - left / spread) if spread else 1.0)


def plot(found: dict[str, Any]) -> str:
    """Return the figure as SVG: least times, fitted lines, numbers. The full bilateral's line leaves the plot."""
    width, height, left, top, right, bottom = 860, 500, 70, 64, 280, 60
    radii: list[int] = found["radii"]
    straight = [run for name, run in found["filters"].items() if not name.endswith("full")]
    highest: float = 1.25 * max(max(run["min"]) for run in straight)
    step: float = next(s for s in (m * 10.0**e for e in range(-6, 3) for m in (1, 2, 5)) if highest / s <= 8)
    ceiling: float = step * math.ceil(highest / step)

    def x(radius: float) -> float:
        return left + (width - left - right) * radius / max(radii)

    def y(second: float) -> float:
        return height - bottom - (height - bottom - top) * second / ceiling

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="DejaVu Sans, Arial, sans-serif" font-size="13" fill="#222">',
        f'<rect width="{width}" height="{height}" fill="#fff"/>',
        f'<text x="{left}" y="26" font-size="16" font-weight="bold">Time against kernel radius (Fig. 23)</text>',
        f'<text x="{left}" y="46" fill="#666">{found["picture"]}, one thread, least of {found["repeats"]} runs</text>',
        f'<clipPath id="in"><rect x="{left}" y="{top}" width="{width - left - right + 8}" '
        f'height="{height - bottom - top}"/></clipPath>',
    ]
    for tick in np.arange(0, ceiling + step / 2, step):
        parts.append(f'<path d="M{left} {y(tick):.1f}H{width - right}" stroke="#ddd"/>')
        parts.append(f'<text x="{left - 8}" y="{y(tick) + 4:.1f}" text-anchor="end">{1000 * tick:g}</text>')
    for radius in radii:
        parts.append(f'<path d="M{x(radius):.1f} {height - bottom}v5" stroke="#222"/>')
        parts.append(f'<text x="{x(radius):.1f}" y="{height - bottom + 20}" text-anchor="middle">{radius}</text>')
    parts.append(f'<path d="M{left} {top}V{height - bottom}H{width - right}" fill="none" stroke="#222"/>')
    middle = (left + width - right) / 2
    parts.append(f'<text x="{middle}" y="{height - 16}" text-anchor="middle">kernel radius, pixels</text>')
    parts.append(
        f'<text x="22" y="{(top + height - bottom) / 2}" text-anchor="middle" '
        f'transform="rotate(-90 22 {(top + height - bottom) / 2})">milliseconds</text>'
    )
    legend = float(top + 10)
    for name, run in found["filters"].items():
        color, line = run["color"], Line(**run["line"])
        is_straight = not name.endswith("full")
        if is_straight:
            ends = [(r, line.intercept + line.slope * r) for r in (radii[0], radii[-1])]
            path = " ".join(f"{x(r):.1f},{y(s):.1f}" for r, s in ends)
            parts.append(f'<polyline points="{path}" stroke="{color}" stroke-width="1.5" clip-path="url(#in)"/>')
        else:
            path = " ".join(f"{x(r):.1f},{y(s):.1f}" for r, s in zip(radii, run["min"], strict=True))
            parts.append(
                f'<polyline points="{path}" fill="none" stroke="{color}" stroke-dasharray="4 3" clip-path="url(#in)"/>'
            )
        parts += [
            f'<circle cx="{x(r):.1f}" cy="{y(s):.1f}" r="3.5" fill="{color}" clip-path="url(#in)"/>'
            for r, s in zip(radii, run["min"], strict=True)
        ]
        column = width - right + 28
        parts.append(f'<circle cx="{column}" cy="{legend - 4}" r="4.5" fill="{color}"/>')
        parts.append(f'<text x="{column + 12}" y="{legend}" font-weight="bold">{name}</text>')
        numbers = (
            f"{1000 * line.slope:.2f} ms per px, R² {line.r2:.4f}"
            if is_straight
            else f"{1000 * run['min'][-1]:.0f} ms at {radii[-1]} px: quadratic"
        )
        parts.append(f'<text x="{column + 12}" y="{legend + 17}" fill="#666">{numbers}</text>')
        legend += 46
    return "\n".join([*parts, "</svg>", ""])


def main(arguments: Sequence[str]) -> None:
    """Measure, print the fits, and write the files asked for."""
    parser = argparse.ArgumentParser(prog="python -m tools.gallery.speed", description="Fig. 23.")
    parser.add_argument("--json", type=Path, help="file for all numbers")
    parser.add_argument("--svg", type=Path, help="file for the plot")
    parser.add_argument("--size", type=int, default=512, help="width and height of the picture")
    parser.add_argument("--radii", type=int, nargs="+", default=RADII, help="kernel radii in pixels")
    parser.add_argument("--repeats", type=int, default=15, help="rounds")
    given = parser.parse_args(arguments)
    found = measure(given.size, given.radii, given.repeats)
    for name, run in found["filters"].items():
        line = Line(**run["line"])
        times = " ".join(f"{1000 * second:.1f}" for second in run["min"])
        print(f"{name:22} {1000 * line.slope:7.2f} ms per px  R^2 {line.r2:.4f}  ms: {times}")
    if given.json:
        given.json.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    if given.svg:
        given.svg.write_text(plot(found), encoding="utf-8")


def _sigma(radius: int) -> float:
    """Return the sigma whose Gaussian is cut at ``radius``: ceil(3 sigma)."""
    return (radius - 0.01) / 3


if __name__ == "__main__":
    main(sys.argv[1:])
