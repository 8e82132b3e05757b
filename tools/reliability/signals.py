"""Stop a run by a signal at random moments, and look at what it left: ``python -m tools.reliability.signals``."""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

from tools.reliability.runs import Size, shot, size_of

FRAMES = 40


@dataclass(frozen=True)
class Outcome:
    """What became of one run that was sent a signal ``moment`` seconds after it began."""

    number: int
    moment: float
    code: int
    seconds: float  #: from the signal to the end
    made: int  #: whole frames
    errors: str
    left: tuple[str, ...]  #: other files in the folder

    @property
    def fault(self) -> str:
        """Return what is wrong, "" for nothing."""
        name = signal.Signals(self.number).name
        if self.code == 124:
            return f"hangs after {name}"
        if self.code == 0 and self.made < FRAMES:
            return f"{name} made it exit 0 with {self.made} of {FRAMES} frames"
        begun = any(f"flowabs_nodes{os.sep}{part}" in self.errors for part in ("signals.py", "cli", "engine"))
        if self.made == 0 and not begun and self.code in (-self.number, 1):
            return ""  # Python was still on its way to our first line
        if self.code not in (0, 128 + self.number):
            return f"exit code {self.code} after {name}: {self.errors.strip()[-300:]}"
        if "Traceback" in self.errors:
            return f"a traceback after {name}: {self.errors.splitlines()[-1]}"
        return f"left behind: {', '.join(self.left)}" if self.left else ""


def stop(
    number: int, moment: float, *, cold: bool = False, jobs: int = 1, size: Size | None = None, patience: float = 60.0
) -> Outcome:
    """Begin a run, send it the signal after ``moment`` seconds, and say what became of it."""
    with shot(FRAMES, size) as here:
        kernels = {"NUMBA_CACHE_DIR": str(here.folder / "cache")} if cold else {}
        with here.begin("--jobs", str(jobs), **kernels) as process:
            time.sleep(moment)
            process.send_signal(number)
            sent = time.monotonic()
            try:
                _, errors = process.communicate(timeout=patience)
                code = process.returncode
            except subprocess.TimeoutExpired:
                process.kill()
                _, errors = process.communicate()
                code = 124
        seconds = time.monotonic() - sent
        frames, others = here.files()
        return Outcome(number, moment, code, seconds, len(frames), errors, tuple(sorted(others)))


def main() -> int:
    """Stop many runs; return 1 if anything was wrong with one of them."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.signals", description=__doc__)
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--longest", type=float, default=4.0, metavar="SECONDS", help="the latest moment (4)")
    parser.add_argument("--cold", action="store_true", help="with an empty folder for kernels")
    parser.add_argument("--jobs", type=int, default=1, help="of each run (1)")
    parser.add_argument("--size", type=size_of, metavar="WxH", help="of the plates (600x400)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # "&" in a script has all that it starts ignore Ctrl-C
    chance = random.Random(given.seed)
    outcomes = []
    for _ in range(given.times):
        number = chance.choice([signal.SIGINT, signal.SIGTERM])
        moment = chance.uniform(0.0, given.longest)
        outcomes.append(stop(number, moment, cold=given.cold, jobs=given.jobs, size=given.size))
        if outcomes[-1].fault:
            print(f"at {outcomes[-1].moment:.3f} s: {outcomes[-1].fault}")
    outcomes.sort(key=lambda each: each.seconds)
    half, last = outcomes[len(outcomes) // 2], outcomes[-1]
    faults = sum(bool(each.fault) for each in outcomes)
    codes = {code: sum(each.code == code for each in outcomes) for code in {each.code for each in outcomes}}
    print(f"{len(outcomes)} runs, {faults} faults, exit codes {codes}")
    longest = f"longest {last.seconds:.2f} s (signal at {last.moment:.3f} s)"
    print(f"from the signal to the end: median {half.seconds:.2f} s, {longest}")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
