"""Start one run many times at once, under two host names, kill some: ``python -m tools.reliability.starts --times 20``.

Every frame must be there once afterwards, whole and the very picture that one run alone makes, and nothing else; and
every run that was not killed must end with exit code 0.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tools.reliability.runs import Shot, Size, pixels_of, shot, size_of

#: The names of two hosts. Both are this machine, so that each sees whether the other's runs live.
HOSTS = ("farm-01", "farm-02")
PATIENCE = 600.0


@dataclass(frozen=True)
class Outcome:
    """What became of runs that were started together: exit codes of those that were left alive, and what is wrong."""

    codes: tuple[int, ...]
    killed: int
    seconds: float
    faults: tuple[str, ...]


def start_together(
    times: int, *, frames: int = 24, kills: int = 0, seed: int = 1, jobs: int = 1, size: Size | None = None
) -> Outcome:
    """Start one run so many times, kill ``kills`` of them at random moments, and say what was wrong."""
    chance = random.Random(seed)
    with shot(frames, size) as here, tempfile.TemporaryDirectory() as log:
        runs, logs = [], []
        began = time.monotonic()
        for index in range(times):
            logs.append(Path(log) / f"{index}.txt")
            with logs[-1].open("w") as errors:
                runs.append(here.begin("--jobs", str(jobs), host=HOSTS[index % len(HOSTS)], stderr=errors))
        victims = chance.sample(runs, kills)
        moments = sorted(chance.uniform(1.0, 4.0 + times / 2) for _ in victims)
        for victim, moment in zip(victims, moments, strict=True):
            time.sleep(max(0.0, began + moment - time.monotonic()))
            victim.kill()
        faults = []
        for index, run in enumerate(runs):
            with suppress(Exception):
                run.wait(max(1.0, began + PATIENCE - time.monotonic()))
            if run.poll() is None:
                run.kill()
                run.wait()
                faults.append(f"run {index} hangs")
            elif run.returncode and run not in victims:
                faults.append(f"run {index} exits {run.returncode}: {logs[index].read_text()[-300:].strip()}")
        codes = tuple(run.returncode for run in runs if run not in victims)
        killed = sum(run.returncode < 0 for run in victims)
        return Outcome(codes, killed, time.monotonic() - began, tuple(faults + _faults_of_frames(here)))


def _faults_of_frames(here: Shot) -> list[str]:
    """Return what is wrong with the frames: all are of one plate, and must be the same picture."""
    made, others = here.files()
    faults = [f"half a frame: {name}" for name in here.damaged()]
    if len(made) < here.frames:
        faults.append(f"{here.frames - len(made)} frames are missing")
    if not faults:
        pictures = {name: pixels_of(here.made / name) for name in sorted(made)}
        expected = next(iter(pictures.values()))
        faults += [f"a frame of mixed pixels: {name}" for name, pixels in pictures.items() if pixels != expected]
    return faults + [f"left behind: {name}" for name in sorted(others)]


def main() -> int:
    """Start many runs at once; return 1 if anything was wrong."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.starts", description=__doc__)
    parser.add_argument("--times", type=int, default=20, help="runs at once (20)")
    parser.add_argument("--kills", type=int, default=6, help="of them that are killed (6)")
    parser.add_argument("--frames", type=int, default=24, help="of the sequence (24)")
    parser.add_argument("--jobs", type=int, default=1, help="of each run (1)")
    parser.add_argument("--size", type=size_of, metavar="WxH", help="of the plates (600x400)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    outcome = start_together(
        given.times, frames=given.frames, kills=given.kills, seed=given.seed, jobs=given.jobs, size=given.size
    )
    for fault in outcome.faults:
        print(fault)
    good = outcome.codes.count(0)
    print(
        f"{given.times} runs at once on {given.frames} frames, {outcome.killed} killed: {len(outcome.faults)} faults;"
    )
    print(f"{good} of the {len(outcome.codes)} others exit 0, after {outcome.seconds:.0f} s")
    return int(bool(outcome.faults))


if __name__ == "__main__":
    sys.exit(main())
