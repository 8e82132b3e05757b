"""Time each stage, whole pipelines and peers, in turns, on a drawn picture: ``python -m tools.bench``."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from flowabs_nodes.errors import CommandError, FlowabsError, nearest
from tools.bench.cases import PIPELINES, STAGES, Plate, chosen
from tools.bench.peers import PEERS, available
from tools.bench.report import Row, from_json, machine, table, to_json
from tools.bench.timing import Elsewhere, Spread, measure, thread_counts

SIZES = {"512": (512, 512), "1080p": (1920, 1080), "4k": (4096, 2160)}


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return the exit code: 2 where the command is wrong, 1 where a measurement failed."""
    given = _parser().parse_args(arguments)
    try:
        _bench(given)
    except FlowabsError as error:
        print(f"bench: {error}", file=sys.stderr)
        return 2 if isinstance(error, CommandError) else 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tools.bench",
        description="How fast the filters are on this machine: median and spread of runs that take turns.",
        epilog=f"Stages: {', '.join([*STAGES, *PIPELINES, *PEERS])}.",
    )
    parser.add_argument("--size", default="512,1080p", help="512, 1080p, 4k or WIDTHxHEIGHT, with commas (512,1080p)")
    parser.add_argument("--stages", default="", metavar="A,B", help="only these")
    parser.add_argument("--seconds", type=float, default=1.0, help="for each stage and number of threads (1)")
    parser.add_argument("--scaling", action="store_true", help="also over radius, sigma, pixels and threads")
    parser.add_argument("--start", action="store_true", help="also whole processes: help, check, first and second run")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all figures here")
    parser.add_argument("--against", type=Path, metavar="FILE", help="ratios to the --json of an earlier run")
    return parser


def _bench(given: argparse.Namespace) -> None:
    # Everything that can be wrong with the command comes first: the rest takes minutes.
    sizes = [_size(text) for text in _list(given.size)]
    names = chosen(_list(given.stages), [*STAGES, *PIPELINES, *PEERS])
    if not (math.isfinite(given.seconds) and given.seconds >= 0):
        raise CommandError(f"--seconds: expected a number of at least 0, found {given.seconds}")
    earlier = from_json(given.against) if given.against else []
    if given.json and not given.json.absolute().parent.is_dir():
        raise CommandError("no such folder", file=str(given.json.parent))
    if not given.stages:
        left_out = sorted(set(PEERS) - set(available()))
        names = tuple(name for name in names if name not in left_out)
        if left_out:
            print(f"without OpenCV (pip install flowabs-nodes[compare]): no {', '.join(left_out)}", file=sys.stderr)
    print("  ".join(f"{key} {value}" for key, value in machine().items()), file=sys.stderr)
    elsewhere = Elsewhere()
    rows = [row for size in sizes for row in _at(size, names, given.seconds)]
    if given.scaling:
        _tell("scaling")
        rows += _scaling(sizes[0], given.seconds)
    if given.start:
        from tools.bench.start import start_times

        _tell("start")
        rows += [Row.of("start", name, (0, 0), 0, "s", spread) for name, spread in start_times().items()]
    if given.json:
        given.json.write_text(to_json(rows), encoding="utf-8")
    print(table(rows, {name: stage.in_p for name, stage in STAGES.items()}, earlier))
    print(f"\nprocessor time that other processes have used meanwhile: {elsewhere}")


def _at(size: tuple[int, int], names: Sequence[str], seconds: float) -> list[Row]:
    """Measure stages, pipelines and peers at one size, all taking turns; then the pipelines' memory."""
    from tools.bench.memory import peak
    from tools.bench.scene import scene

    plate = Plate(scene(*size))
    makers = {**{name: stage.case for name, stage in STAGES.items()}, **PIPELINES, **PEERS}
    _tell(f"{size[0]}x{size[1]}")
    counts = thread_counts()
    taken = measure({name: makers[name](plate) for name in names}, counts, seconds)
    nanoseconds = 1e9 / (size[0] * size[1])
    rows = []
    for (name, threads), spread in taken.items():
        if name in PIPELINES:
            rows.append(Row.of("pipeline", name, size, threads, "ms", spread.times(1e3)))
        else:
            section = "stage" if name in STAGES else "peer"
            rows.append(Row.of(section, name, size, threads, "ns/px", spread.times(nanoseconds)))
    for name in (name for name in names if name in PIPELINES):
        megabytes = peak(name, plate.rgb)
        if megabytes is not None:
            rows.append(Row.of("memory", name, size, counts[-1], "MB/MP", Spread.of([megabytes])))
    return rows


def _scaling(size: tuple[int, int], seconds: float) -> list[Row]:
    from tools.bench import scaling

    most = thread_counts()[-1]
    return [
        *scaling.sweeps(size, seconds),
        *scaling.pixels(seconds),
        *scaling.threads(size, most, seconds),
    ]


def _size(text: str) -> tuple[int, int]:
    """Return the size of a name or of WIDTHxHEIGHT."""
    if text.lower() in SIZES:
        return SIZES[text.lower()]
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if found is None or min(map(int, found.groups())) == 0:
        raise CommandError(f"no size {text!r}", hint=nearest(text, [*SIZES, "WIDTHxHEIGHT"]), code="unknown-size")
    return int(found[1]), int(found[2])


def _list(text: str) -> list[str]:
    return [part.strip() for part in text.split(",") if part.strip()]


def _tell(what: str) -> None:
    print(f"measuring: {what}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
