"""Report measurements as rows, as JSON, as a table, and as ratios to an earlier run.

Tables show medians, spreads and least times. What is made of them (gains, shares, ratios, lines) is made of the least:
what a machine does besides can only make a time longer.
"""

from __future__ import annotations

import json
import os
import platform
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import flowabs_nodes
from flowabs_nodes.errors import CommandError
from tools.bench.timing import Spread

FORMAT = "flowabs.bench/1"
ENVIRONMENT = ("FLOWABS_SIMD", "NUMBA_CPU_NAME", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER", "OMP_WAIT_POLICY")
Key = tuple[str, str, int, int, int, float | None]


@dataclass(frozen=True)
class Row:
    """One measurement, of a section: stage, pipeline, memory, peer, scaling (of ``value``, a parameter's) or start.

    ``width``, ``height`` and ``threads`` are 0 where they mean nothing.
    """

    section: str
    name: str
    width: int
    height: int
    threads: int
    unit: str
    median: float
    low: float
    high: float
    least: float
    rounds: int
    value: float | None = None

    @classmethod
    def of(
        cls,
        section: str,
        name: str,
        size: tuple[int, int],
        threads: int,
        unit: str,
        spread: Spread,
        value: float | None = None,
    ) -> Row:
        width, height = size
        median, low, high, least, rounds = spread
        return cls(section, name, width, height, threads, unit, median, low, high, least, rounds, value)

    @property
    def key(self) -> Key:
        return self.section, self.name, self.width, self.height, self.threads, self.value


def to_json(rows: Iterable[Row]) -> str:
    """Return all rows, and the machine they were measured on, as JSON."""
    found = {"format": FORMAT, "machine": machine(), "rows": [asdict(row) for row in rows]}
    return json.dumps(found, indent=1) + "\n"


def from_json(file: Path) -> list[Row]:
    """Return the rows of an earlier run from its JSON file.

    Raises
    ------
    CommandError
        For a file that is not there or that no bench has written.
    """
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        if found["format"] != FORMAT:
            raise CommandError(f"expected {FORMAT!r}, found {found['format']!r}", file=str(file))
        return [Row(**row) for row in found["rows"]]
    except OSError as error:
        raise CommandError(f"cannot be read: {error.strerror}", file=str(file)) from error
    except (ValueError, KeyError, TypeError) as error:
        raise CommandError("is not what --json of a bench writes", file=str(file)) from error


def machine() -> dict[str, Any]:
    """Return the properties of machine and software that measurements depend on."""
    return {
        "when": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "system": platform.platform(),
        "python": platform.python_version(),
        "flowabs": flowabs_nodes.__version__,
        **{name: os.environ[name] for name in ENVIRONMENT if name in os.environ},
        **{package: _version(package) for package in ("numba", "llvmlite", "numpy", "opencv-python-headless")},
    }


def table(rows: Sequence[Row], in_p: Mapping[str, int], earlier: Sequence[Row] = ()) -> str:
    """Return all measurements as text; ``in_p`` tells how often the pipeline P runs each stage."""
    before = {row.key: row for row in earlier}
    parts = []
    for section in ("stage", "peer", "pipeline"):
        sizes = dict.fromkeys((row.width, row.height) for row in rows if row.section == section)
        for size in sizes:
            these = [row for row in rows if row.section == section and (row.width, row.height) == size]
            shares = _shares(rows, size, in_p) if section == "stage" else {}
            parts.append(_by_threads(section, size, these, shares, before))
    for section, title in (("memory", "peak memory above the plate's own"), ("start", "whole process")):
        parts.append(_plain(title, [row for row in rows if row.section == section], before))
    parts.append(_scaling([row for row in rows if row.section == "scaling"], before))
    if before:
        parts.append(_summary(rows, before))
    return "\n\n".join(part for part in parts if part)


def _by_threads(
    section: str, size: tuple[int, int], rows: Sequence[Row], shares: Mapping[str, float], before: Mapping[Key, Row]
) -> str:
    """Return a line for each name, with a pair of columns for each number of threads."""
    counts = sorted({row.threads for row in rows})
    titles = [f"{_threads(count):>12}    ±   least{'  ratio' if before else ''}" for count in counts]
    head = f"{section:26}" + "".join(titles) + (f"{'gain':>8}" if len(counts) > 1 else "")
    lines = [f"{size[0]}x{size[1]}, {rows[0].unit}", head + (f"{'share of P':>13}" if shares else "")]
    for name in dict.fromkeys(row.name for row in rows):
        found = {row.threads: row for row in rows if row.name == name}
        line = f"{name:26}" + "".join(_figure(found[count], before) for count in counts)
        if len(counts) > 1:
            line += f"{found[counts[0]].least / found[counts[-1]].least:7.2f}x"
        if name in shares:
            line += f"{shares[name]:12.1%}"
        lines.append(line.rstrip())
    if shares:
        lines.append(f"{'the rest of P':26}" + " " * (len(head) - 26) + f"{1 - sum(shares.values()):12.1%}")
    return "\n".join(lines)


def _shares(rows: Iterable[Row], size: tuple[int, int], in_p: Mapping[str, int]) -> dict[str, float]:
    """Return each stage's share of P's time on one thread, if P was measured too."""
    single = [row for row in rows if (row.width, row.height, row.threads) == (*size, 1)]
    whole = next((row.least for row in single if (row.section, row.name) == ("pipeline", "P")), None)
    if whole is None:
        return {}
    per_pixel = whole / 1e-6 / (size[0] * size[1])  # ms to ns/px
    stages = [row for row in single if row.section == "stage" and in_p.get(row.name, 0) > 0]
    return {row.name: row.least * in_p[row.name] / per_pixel for row in stages}


def _plain(title: str, rows: Sequence[Row], before: Mapping[Key, Row]) -> str:
    lines = [
        f"{row.name:42}{f'{row.width}x{row.height}' if row.width else '':>12}{_figure(row, before)} {row.unit}"
        for row in rows
    ]
    return "\n".join([title, *lines]) if lines else ""


def _scaling(rows: Sequence[Row], before: Mapping[Key, Row]) -> str:
    """Return each sweep on a line or two: its figures, and how straight the line through them is."""
    lines = []
    for name in dict.fromkeys(row.name for row in rows):
        sweep = [row for row in rows if row.name == name]
        lines.append(f"{name}, {sweep[0].unit}")
        lines += [f"{row.value or 0:10g}{_figure(row, before)}" for row in sweep]
        if len(sweep) > 2 and not name.startswith("P "):  # lengths: their cost is a straight line, or should be
            from tools.gallery.speed import fit

            line = fit([row.value or 0 for row in sweep], [row.least for row in sweep])
            lines.append(f"{'':10}{line.intercept:.1f} + {line.slope:.2f} per px, R^2 {line.r2:.4f}")
    return "\n".join(["scaling", *lines]) if lines else ""


def _figure(row: Row, before: Mapping[Key, Row]) -> str:
    """Return a row's median, distance between quartiles as a part of it, least time, and ratio to the earlier run."""
    spread = (row.high - row.low) / abs(row.median) if row.median else 0.0
    text = f"{row.median:12.2f} {min(spread, 9.99):4.0%}{row.least:8.2f}"
    if before:
        ratio = _ratio(row, before)
        text += "      -" if ratio is None else f"{ratio:6.2f}x"
    return text


def _summary(rows: Iterable[Row], before: Mapping[Key, Row]) -> str:
    """Return the ratios over all of flowabs, and over the peers, which show how the machine itself has changed."""
    ratios = [(row, ratio) for row in rows if (ratio := _ratio(row, before)) is not None]
    foreign = [ratio for row, ratio in ratios if row.section == "peer" and row.name != "dog"]
    ours = [ratio for row, ratio in ratios if row.section in ("stage", "pipeline")]
    texts = [
        f"{what}: {statistics.geometric_mean(found):.2f}x the earlier time ({len(found)} figures, geometric mean)"
        for what, found in (("stages and pipelines", ours), ("the machine itself, by what is not ours", foreign))
        if found
    ]
    return "\n".join(texts or ["nothing in common with the earlier run"])


def _ratio(row: Row, before: Mapping[Key, Row]) -> float | None:
    """Return the ratio to the earlier run; None where the earlier run has no such row, or one is lost in noise."""
    other = before.get(row.key)
    return row.least / other.least if other is not None and other.least > 0 and row.least > 0 else None


def _threads(count: int) -> str:
    return f"{count} thread{'s' if count > 1 else ''}"


def _processor() -> str:
    """Return the processor's name on Linux, elsewhere its architecture."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8", errors="replace").splitlines() if info.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        return None
