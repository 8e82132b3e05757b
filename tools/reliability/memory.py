"""Watch the memory of a run over many frames: it must not grow. ``python -m tools.reliability.memory`` (Linux).

What counts is the proportional set size (PSS) of a run's processes together, in which a page that several share counts
once; and its slope, fitted from the first fifth of the frames on: what is loaded and compiled is there by then.
Other programs that share Python's libraries and end meanwhile make a run seem to grow: measure where nothing else runs.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tools.reliability.kills import children
from tools.reliability.runs import Size, shot, size_of

#: Megabytes by which a run may seem to grow from its first fifth to its end: memory that is kept for later frames.
GROWTH = 16.0
_LOOK = 0.05  # seconds between two looks


@dataclass(frozen=True)
class Outcome:
    """What a run took: (frames made, megabytes of PSS) of each look, and its exit code."""

    looks: tuple[tuple[int, float], ...]
    code: int
    errors: str
    frames: int

    @property
    def peak(self) -> float:
        """Return the most megabytes."""
        return max((megabytes for _, megabytes in self.looks), default=0.0)

    @property
    def slope(self) -> float:
        """Return by how many megabytes the run grows with each frame, from a fifth of them on."""
        late = np.array([look for look in self.looks if look[0] >= self.frames // 5])
        if len(late) < 10:
            return 0.0
        # The peak of each frame: between two frames their memory may have been given back.
        made = np.unique(late[:, 0])
        peaks = [late[late[:, 0] == each, 1].max() for each in made]
        return float(np.polyfit(made, peaks, 1)[0])

    @property
    def fault(self) -> str:
        """Return what is wrong, "" for nothing."""
        if self.code:
            return f"exit code {self.code}: {self.errors.strip()[-300:]}"
        grown = self.slope * 0.8 * self.frames
        return f"it grows by {grown:.0f} MB in {self.frames} frames" if grown > GROWTH else ""


def watch(graph: str, frames: int, jobs: int, size: Size | None = None) -> Outcome:
    """Run a graph over frames, and look at what its processes take."""
    looks = []
    with shot(frames, size) as here, here.begin("--jobs", str(jobs), graph=graph) as process:
        while process.poll() is None:
            looks.append((len(here.files()[0]), sum(map(pss, family(process.pid))) / 1e6))
            time.sleep(_LOOK)
        _, errors = process.communicate()
    return Outcome(tuple(looks), process.returncode, errors or "", frames)


def family(process: int) -> list[int]:
    """Return a process and all that descend from it."""
    return [process, *(each for child in children(process) for each in family(child))]


def pss(process: int) -> int:
    """Return the proportional set size of a process in bytes; 0 once it has ended."""
    with suppress(OSError):
        found = re.search(r"^Pss:\s+(\d+)", Path(f"/proc/{process}/smaps_rollup").read_text(encoding="ascii"), re.M)
        return 1024 * int(found[1]) if found else 0
    return 0


def main() -> int:
    """Watch a run in one process and one in two; return 1 if one of them grows."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.memory", description=__doc__)
    parser.add_argument("--frames", type=int, default=500)
    parser.add_argument("--graph", default="abstraction")
    parser.add_argument("--size", type=size_of, default=(480, 270), metavar="WxH", help="of the plates (480x270)")
    parser.add_argument("--jobs", type=int, nargs="+", default=[1, 2], help="of the runs (1 2)")
    given = parser.parse_args()
    wrong = 0
    for jobs in given.jobs:
        outcome = watch(given.graph, given.frames, jobs, given.size)
        what = f"{given.frames} frames with --jobs {jobs}: {len(outcome.looks)} looks, peak {outcome.peak:.0f} MB"
        print(
            f"{what}, {1000 * outcome.slope:+.1f} kB a frame{'; ' if outcome.fault else ''}{outcome.fault}", flush=True
        )
        wrong += bool(outcome.fault)
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
