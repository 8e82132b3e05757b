"""Measure how the time grows with each length, with the number of pixels, with the number of threads."""

from __future__ import annotations

from collections.abc import Callable

from flowabs_nodes import filters
from tools.bench.cases import PIPELINES, Plate
from tools.bench.report import Row
from tools.bench.scene import scene
from tools.bench.timing import Case, measure

Run = Callable[[Plate, float], object]

# A parameter, its values, and the stage as a function of it. FBL is one iteration, ETF is all three.
SWEEPS: dict[str, tuple[tuple[float, ...], Run]] = {
    "etf-full radius": ((3, 5, 10, 20, 40), lambda p, r: filters.etf(p.code, radius=r)),
    "etf-separable radius": ((3, 5, 10, 20, 40), lambda p, r: filters.etf(p.code, radius=r, kernel="separable")),
    "fdog sigma_m": ((1, 3, 6, 12), lambda p, s: filters.fdog(p.code, p.flow, sigma_m=s)),
    "fdog sigma_c": ((0.5, 1, 2, 4), lambda p, s: filters.fdog(p.code, p.flow, sigma_c=s)),
    "flow-blur sigma": ((1, 2, 4, 8), lambda p, s: filters.flow_blur(p.lines, p.flow, sigma=s)),
    "fbl sigma_e": ((1, 2, 4, 8), lambda p, s: filters.fbl(p.codes, p.flow, sigma_e=s, iterations=1)),
    "fbl sigma_g": ((0.5, 1, 2, 4), lambda p, s: filters.fbl(p.codes, p.flow, sigma_g=s, iterations=1)),
    "bilateral-full sigma_d": ((1, 2, 3), lambda p, s: filters.bilateral(p.codes, sigma_d=s, iterations=1)),
    "bilateral-xy sigma_d": ((1, 2, 4, 8), lambda p, s: filters.bilateral(p.codes, s, iterations=1, kernel="xy")),
    "blur sigma": ((1, 4, 16), lambda p, s: filters.blur(p.codes, s)),
}
SIDES = (256, 512, 1024, 2048)


def sweeps(size: tuple[int, int], seconds: float) -> list[Row]:
    """Measure ns per pixel on one thread for each value of each parameter."""
    plate = Plate(scene(*size))
    cases = {(name, value): _case(plate, run, value) for name, (values, run) in SWEEPS.items() for value in values}
    taken = measure({f"{name}={value:g}": case for (name, value), case in cases.items()}, (1,), seconds)
    pixels = size[0] * size[1]
    return [
        Row.of("scaling", name, size, 1, "ns/px", taken[f"{name}={value:g}", 1].times(1e9 / pixels), value)
        for name, value in cases
    ]


def pixels(seconds: float, sides: tuple[int, ...] = SIDES) -> list[Row]:
    """Measure ns per pixel of the pipeline P on pictures of several sizes, on one thread."""
    cases = {str(side): PIPELINES["P"](Plate(scene(side, side))) for side in sides}
    taken = measure(cases, (1,), seconds)
    return [
        Row.of("scaling", "P width", (side, side), 1, "ns/px", taken[str(side), 1].times(1e9 / side**2), side)
        for side in sides
    ]


def threads(size: tuple[int, int], most: int, seconds: float) -> list[Row]:
    """Measure milliseconds of the pipeline P on one thread, two, four and so on up to all."""
    counts = sorted({*(2**k for k in range(most.bit_length()) if 2**k <= most), most})
    taken = measure({"P": PIPELINES["P"](Plate(scene(*size)))}, counts, seconds)
    return [Row.of("scaling", "P threads", size, n, "ms", taken["P", n].times(1000), n) for n in counts]


def _case(plate: Plate, run: Run, value: float) -> Case:
    return Case(lambda _: run(plate, value))
