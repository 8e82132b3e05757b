"""Render through the OpenFX plug-in a thousand times, and kill its server: ``python -m tools.reliability.openfx``.

The host is that of the tests. Every frame has the bits of Python, or the host was told why it has none; nothing is left
of images, files, shared memory, and nobody waits for a server that is gone. Linux.
"""

from __future__ import annotations

import argparse
import importlib
import os
import random
import resource
import signal
import sys
import tempfile
import threading
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from flowabs_nodes.engine.session import Session
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.openfx import bundle
from tools.reliability.runs import PICTURE

PATIENCE = 90.0  # seconds after which a frame counts as one that hangs
_ALLOWED_MB = 24  # what Python itself may take more at the end: lists, freed memory


@dataclass
class Outcome:
    """What became of many frames."""

    frames: int = 0
    kills: int = 0
    failed: int = 0  #: frames that the host was told have failed
    longest: float = 0.0  #: seconds
    faults: list[str] = field(default_factory=list)


def render_many(frames: int, kills: int, seed: int = 1, side: int = 96, graph: str = "abstraction") -> Outcome:
    """Render frames with other parameters each time, while servers are killed; every third kill is one without end.

    Such a kill hits the server that is started for the second try as well: that frame has to fail, with a message.
    """
    host_module, images, processes = (
        importlib.import_module(f"tests.openfx.{name}") for name in ("host", "images", "processes")
    )
    chance, outcome = random.Random(seed), Outcome()
    victims = set(chance.sample(range(10, frames), kills))
    plate = read_image(str(PICTURE)).pixels
    plate = np.tile(plate, (side // plate.shape[0] + 1, side * 16 // 9 // plate.shape[1] + 1, 1))[
        :side, : side * 16 // 9
    ]
    source = np.ones((*plate.shape[:2], 4), np.float32)
    source[..., :3] = plate
    with (
        tempfile.TemporaryDirectory() as folder,
        Session(graph, cache_bytes=2**20, on_event=lambda event: None) as python,
    ):
        made, _ = bundle.build(Path(folder), [])
        python.given(plate=Image.from_array(source))
        host = host_module.Host(next(made.glob("Contents/*/Flowabs.ofx")))
        instance = host.plugin(graph).instance()
        instance.clips["Source"].connect(images.Held(source))
        instance.clips["Output"].connect(images.Held(np.zeros_like(source)))
        before: dict[str, float] = {}
        for frame in range(frames):
            if frame == 50:
                before = _counts(processes)
            values = {"simplify": chance.uniform(0, 1), "levels": chance.randint(4, 16)}
            instance.set(**values)
            killer = _Killer(chance.uniform(0, 0.03), chance.random() < 1 / 3, processes) if frame in victims else None
            began = time.monotonic()
            got = instance.render(expect=None)
            outcome.longest = max(outcome.longest, time.monotonic() - began)
            if killer is not None:
                outcome.kills += killer.end()
            _judge(frame, instance, got, python, values, outcome, host_module)
            host.log.clear()
        outcome.faults += [f"afterwards: {fault}" for fault in _leaks(before, _counts(processes))]
        instance.destroy()
        host.close()
        outcome.faults += host.faults
        outcome.faults += [f"a server is left: {number}" for number in processes.children()]
        outcome.faults += [f"memory is left: {name}" for name in processes.left_in_memory()]
        if host.taken != host.given_back:
            outcome.faults.append(f"{host.taken} images taken, {host.given_back} given back")
    if outcome.longest > PATIENCE:
        outcome.faults.append(f"a frame took {outcome.longest:.0f} s")
    return outcome


def _judge(
    frame: int, instance: Any, got: Any, python: Session, values: dict[str, Any], outcome: Outcome, host: Any
) -> None:
    """Compare a frame with Python's, or look at what was said of it."""
    outcome.frames += 1
    if instance.last != host.OK:
        outcome.failed += 1
        if instance.message is None:
            outcome.faults.append(f"frame {frame}: failed without a word")
        return
    if instance.message is not None:
        outcome.faults.append(f"frame {frame}: made, but {instance.message}")
    python.set(values)
    if not np.array_equal(got, next(iter(python.run().values())).to_array(channels="RGBA")):
        outcome.faults.append(f"frame {frame}: other pixels than Python's")


class _Killer:
    """Kills a server after some seconds; ``again``: each one that follows, until :meth:`end`."""

    def __init__(self, after: float, again: bool, processes: Any) -> None:
        self._after, self._again, self._processes = after, again, processes
        self._over, self._killed = threading.Event(), 0
        self._thread = threading.Thread(target=self._work)
        self._thread.start()

    def end(self) -> int:
        """Stop killing; return how many were killed."""
        self._over.set()
        self._thread.join()
        return self._killed

    def _work(self) -> None:
        time.sleep(self._after)
        while True:
            for number in self._processes.children():
                with suppress(ProcessLookupError):
                    os.kill(number, signal.SIGKILL)
                    self._killed += 1
            if not self._again or self._over.wait(0.02):
                return


def _counts(processes: Any) -> dict[str, float]:
    """Return what must not grow: open files, mapped shared memory, threads, the most memory that was in use (MB)."""
    maps = Path("/proc/self/maps").read_text(encoding="utf-8").count("/flowabs-")
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    resident = int(status.partition("VmRSS:")[2].split()[0]) / 1024
    threads = int(status.partition("Threads:")[2].split()[0])
    return {"files": processes.open_files(), "mapped": maps, "threads": threads, "MB": resident}


def _leaks(before: dict[str, float], after: dict[str, float]) -> list[str]:
    """Return a sentence for each count that has grown."""
    allowed = {"files": 1, "mapped": 1, "threads": 1, "MB": _ALLOWED_MB}  # a server that was not there at first
    return [
        f"{name}: {before[name]:g} at first, {after[name]:g} at the end"
        for name in before
        if after[name] > before[name] + allowed[name]
    ]


def main() -> int:
    """Render many frames; return 1 if anything was wrong with one of them."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.openfx", description=__doc__)
    parser.add_argument("--times", type=int, default=1000, help="frames (1000)")
    parser.add_argument("--kills", type=int, default=50, help="frames whose server is killed (50)")
    parser.add_argument("--side", type=int, default=96, help="the height of the picture (96; 8K: 4320)")
    parser.add_argument("--graph", default="abstraction", help="one with the knobs simplify and levels (abstraction)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    outcome = render_many(given.times, given.kills, given.seed, given.side, given.graph)
    for fault in outcome.faults:
        print(fault)
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{outcome.frames} frames, {outcome.kills} servers killed in {given.kills} of them; {outcome.failed} failed "
        f"and said so, {len(outcome.faults)} faults; the longest took {outcome.longest:.1f} s; host {most:.0f} MB"
    )
    return int(bool(outcome.faults))


if __name__ == "__main__":
    sys.exit(main())
