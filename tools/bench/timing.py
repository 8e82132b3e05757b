"""Time many cases in turns, so that whatever else the machine does slows all of them alike."""

from __future__ import annotations

import os
import random
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

LEAST, MOST = 3, 100  # rounds of one case


def _nothing() -> None:
    return None


@dataclass(frozen=True)
class Case:
    """A function to time.

    Parameters
    ----------
    run
        The function to time. Its argument is made by ``fresh`` just before the clock starts.
    less
        The part of ``run`` that does not count: its time, taken right after, is subtracted.
    per
        How often ``run`` repeats the work to time, such as its iterations.
    """

    run: Callable[[Any], object]
    fresh: Callable[[], Any] = _nothing
    less: Callable[[Any], object] | None = None
    per: int = 1

    def seconds(self) -> tuple[float, float]:
        """Return one measurement, in seconds, of ``run`` and of ``less``."""
        taken = _seconds(self.run, self.fresh())
        return taken, 0.0 if self.less is None else _seconds(self.less, self.fresh())

    def spread(self, found: Sequence[tuple[float, float]]) -> Spread:
        """Return the spread of measurements; its least is the least ``run`` minus the least ``less``: less noisy."""
        least = min(run for run, _ in found) - min(less for _, less in found)
        return Spread.of([(run - less) / self.per for run, less in found])._replace(least=least / self.per)


class Spread(NamedTuple):
    """A summary of several measurements: the median, the quartiles around it, the least, and their number."""

    median: float
    low: float
    high: float
    least: float
    rounds: int

    @classmethod
    def of(cls, found: Sequence[float]) -> Spread:
        if len(found) == 1:
            return cls(found[0], found[0], found[0], found[0], 1)
        low, median, high = statistics.quantiles(found, n=4, method="inclusive")
        return cls(median, low, high, min(found), len(found))

    def times(self, factor: float) -> Spread:
        """Return the spread in another unit."""
        return Spread(self.median * factor, self.low * factor, self.high * factor, self.least * factor, self.rounds)


def measure(cases: Mapping[str, Case], threads: Sequence[int], seconds: float) -> dict[tuple[str, int], Spread]:
    """Measure the seconds of each case on each number of threads.

    All take turns, in another order each round; a case that has had ``seconds`` is left out of further rounds,
    but none is measured less than three times. Each case has run once before, so that its kernels are compiled.
    """
    for case in cases.values():
        case.seconds()
    todo = [(name, count) for name in cases for count in threads]
    found: dict[tuple[str, int], list[tuple[float, float]]] = {key: [] for key in todo}
    spent = dict.fromkeys(todo, 0.0)
    order = random.Random(2009)
    while todo:
        order.shuffle(todo)
        for key in todo:
            name, count = key
            begin = time.perf_counter()
            with on_threads(count):
                found[key].append(cases[name].seconds())
            spent[key] += time.perf_counter() - begin
        todo = [key for key in todo if len(found[key]) < LEAST or (spent[key] < seconds and len(found[key]) < MOST)]
    return {key: cases[key[0]].spread(taken) for key, taken in found.items()}


@contextmanager
def on_threads(count: int) -> Iterator[None]:
    """Run the body with ``count`` threads for kernels and, where it is in use, OpenCV."""
    from flowabs_nodes.simd import bands

    cv2 = sys.modules.get("cv2")
    before = cv2.getNumThreads() if cv2 is not None else 0
    try:
        if cv2 is not None:
            cv2.setNumThreads(count)
        with bands.limited(count):
            yield
    finally:
        if cv2 is not None:
            cv2.setNumThreads(before)


class Elsewhere:
    """The share of the processors that other processes have used since this object was made; only Linux tells."""

    def __init__(self) -> None:
        self.before = self._busy()

    def __str__(self) -> str:
        if self.before is None or (now := self._busy()) is None:
            return "unknown"
        busy, own, all_ = (b - a for a, b in zip(self.before, now, strict=True))
        return f"{max(busy - own, 0) / max(all_, 0.01):.0%}"

    @staticmethod
    def _busy() -> tuple[float, float, float] | None:
        """Return the seconds of all processors: used, used by this process, and in total."""
        stat = Path("/proc/stat")
        if not stat.exists():
            return None
        ticks = [int(field) for field in stat.read_text(encoding="ascii").split("\n", 1)[0].split()[1:9]]
        second = os.sysconf("SC_CLK_TCK")
        own = os.times()
        used = own.user + own.system + own.children_user + own.children_system
        return (sum(ticks) - ticks[3] - ticks[4]) / second, used, sum(ticks) / second


def thread_counts() -> tuple[int, ...]:
    """Return the numbers of threads to measure on: one, and all."""
    from flowabs_nodes.simd.bands import available_threads

    return tuple(sorted({1, available_threads()}))


def _seconds(run: Callable[[Any], object], given: Any) -> float:
    begin = time.perf_counter()
    run(given)
    return time.perf_counter() - begin
