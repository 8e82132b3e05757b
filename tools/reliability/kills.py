"""Kill a run, or one of its processes, at random moments, and go on: ``python -m tools.reliability.kills``.

At no moment may there be half a frame; going on makes the missing frames only, and leaves nothing else behind.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tools.reliability.runs import Shot, Size, shot, size_of


@dataclass(frozen=True)
class Outcome:
    """What became of a run of which something was killed ``moment`` seconds after it began."""

    victim: str
    moment: float
    made: int  #: frames that were there at that moment
    faults: tuple[str, ...]


def kill(victim: str, moment: float, *, frames: int = 24, jobs: int = 2, size: Size | None = None) -> Outcome:
    """Begin a run, kill the "run" or a "worker" of it after ``moment`` seconds, resume it, and say what was wrong."""
    with shot(frames, size) as here:
        with here.begin("--jobs", str(jobs)) as process:
            time.sleep(moment)
            if victim == "run":
                process.kill()
            else:
                for child in children(process.pid)[:1]:
                    with suppress(ProcessLookupError):
                        os.kill(child, signal.SIGKILL)
            made, _ = here.files()
            _, errors = process.communicate(timeout=120)
        faults = []
        if victim == "worker" and process.returncode:
            faults.append(f"a worker that was killed made the run exit {process.returncode}: {errors.strip()[-300:]}")
        faults += [f"half a frame: {name}" for name in here.damaged()]
        faults += _faults_of_resuming(here)
        return Outcome(victim, moment, len(made), tuple(faults))


def _faults_of_resuming(here: Shot) -> list[str]:
    """Go on with a run that was killed, and return what is wrong afterwards."""
    before = {name: (here.made / name).stat().st_mtime_ns for name in here.files()[0]}
    with here.begin() as process:
        _, errors = process.communicate(timeout=300)
    faults = [f"resume: exit code {process.returncode}: {errors.strip()[-300:]}"] if process.returncode else []
    made, others = here.files()
    if len(made) < here.frames:
        faults.append(f"resume: {here.frames - len(made)} frames are missing")
    faults += [f"resume: {name} was made again" for name in before if _time_of(here.made / name) != before[name]]
    faults += [f"resume: half a frame: {name}" for name in here.damaged()]
    return faults + [f"resume: left behind: {name}" for name in sorted(others)]


def _time_of(path: Path) -> int:
    return path.stat().st_mtime_ns if path.exists() else 0


def children(process: int) -> list[int]:
    """Return the processes that one has begun (Linux)."""
    found: list[int] = []
    with suppress(OSError):
        for thread in Path(f"/proc/{process}/task").iterdir():
            with suppress(OSError):
                found += map(int, (thread / "children").read_text(encoding="ascii").split())
    return found


def main() -> int:
    """Kill many runs; return 1 if anything was wrong with one of them."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.kills", description=__doc__)
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--earliest", type=float, default=0.1, metavar="SECONDS", help="the earliest moment (0.1)")
    parser.add_argument("--longest", type=float, default=4.0, metavar="SECONDS", help="the latest moment (4)")
    parser.add_argument("--frames", type=int, default=24, help="of each run (24)")
    parser.add_argument("--size", type=size_of, metavar="WxH", help="of the plates (600x400)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    outcomes = []
    for _ in range(given.times):
        victim, moment = chance.choice(["run", "worker"]), chance.uniform(given.earliest, given.longest)
        outcomes.append(kill(victim, moment, frames=given.frames, size=given.size))
        for fault in outcomes[-1].faults:
            print(f"{outcomes[-1].victim} killed at {outcomes[-1].moment:.3f} s: {fault}")
    faults = sum(bool(each.faults) for each in outcomes)
    between = sum(0 < each.made < given.frames for each in outcomes)
    print(f"{len(outcomes)} kills, {between} of them in the middle of the frames; {faults} with faults")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
