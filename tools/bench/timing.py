"""Taking times: many cases in turns, so that whatever else the machine does meets all of them."""

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
    """Something to time.

    Parameters
    ----------
    run
        What is timed. It gets what ``fresh`` has made just before the clock started.
    less
        What ``run`` does too but is not meant: its time, taken right after, is subtracted.
    per
        How often ``run`` does what is meant, such as its iterations.
    """

    run: Callable[[Any], object]
    fresh: Callable[[], Any] = _nothing
    less: Callable[[Any], object] | None = None
    per: int = 1

    def seconds(self) -> tuple[float, float]:
        """One measurement: of ``run`` and of ``less``."""
        taken = _seconds(self.run, self.fresh())
        return taken, 0.0 if self.less is None else _seconds(self.less, self.fresh())

    def spread(self, found: Sequence[tuple[float, float]]) -> Spread:
        """What measurements come to. The least is that of each of the two: the least difference is one of noise."""
        least = min(run for run, _ in found) - min(less for _, less in found)
        return Spread.of([(run - less) / self.per for run, less in found])._replace(least=least / self.per)


class Spread(NamedTuple):
    """What several measurements come to: the middle, the quartiles around it, the least, and how many they were."""

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
        """In another unit."""
        return Spread(self.median * factor, self.low * factor, self.high * factor, self.least * factor, self.rounds)


def measure(cases: Mapping[str, Case], threads: Sequence[int], seconds: float) -> dict[tuple[str, int], Spread]:
    """Seconds of each case on each number of threads.

    All take turns, in another order each round; one that has had ``seconds`` is left out of further rounds, but none
    is measured less than three times. Each has run once before, so that everything is compiled and in place.
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
    """Inside, kernels and, where it is in use, OpenCV work on so many threads."""
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
    """How much of the processors other processes have used since this was made; only Linux tells."""

    def __init__(self) -> None:
        self.before = self._busy()

    def __str__(self) -> str:
        if self.before is None or (now := self._busy()) is None:
            return "unknown"
        busy, own, all_ = (b - a for a, b in zip(self.before, now, strict=True))
        return f"{max(busy - own, 0) / max(all_, 0.01):.0%}"

    @staticmethod
    def _busy() -> tuple[float, float, float] | None:
        """Seconds of all processors: in use, in use by this process, and there in all."""
        stat = Path("/proc/stat")
        if not stat.exists():
            return None
        ticks = [int(field) for field in stat.read_text(encoding="ascii").split("\n", 1)[0].split()[1:9]]
        second = os.sysconf("SC_CLK_TCK")
        own = os.times()
        used = own.user + own.system + own.children_user + own.children_system
        return (sum(ticks) - ticks[3] - ticks[4]) / second, used, sum(ticks) / second


def thread_counts() -> tuple[int, ...]:
    """One thread, and all there are."""
    from flowabs_nodes.simd.bands import available_threads

    return tuple(sorted({1, available_threads()}))


def _seconds(run: Callable[[Any], object], given: Any) -> float:
    begin = time.perf_counter()
    run(given)
    return time.perf_counter() - begin
