"""Let the disk be full, at every point of a frame: ``python -m tools.reliability.full_disk --times 50``.

A limit on the size of a file stops a frame at any byte of it; a small tmpfs, where one may be mounted, at any page.
There may be no frame then and nothing else, and the run ends at once, with exit code 1 and a message that says why.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO as oiio

from tools.reliability.runs import CHECKOUT

#: What is written, by name: the file's extension, and the compression.
KINDS = {
    "zip": (".exr", "zip"),
    "piz": (".exr", "piz"),
    "none": (".exr", "none"),
    "dwaa": (".exr", "dwaa"),
    "png": (".png", "auto"),
    "tiff": (".tif", "auto"),
}
PATIENCE = 60.0
_PAGE = 4096
#: What a message says where a disk is full, and where a file may not become larger.
_SAID = ("no space is left", "File too large")
_GRAPH = {
    "format": "flowabs.graph/1",
    "nodes": {
        "plate": {"type": "read@1"},
        "out": {"type": "write@1", "inputs": {"image": "plate"}},
    },
}


@dataclass(frozen=True)
class Outcome:
    """What became of one run whose frame could not be written whole: ``code`` is None where it hangs."""

    kind: str
    short: int  #: bytes that there is no room for
    code: int | None
    errors: str
    left: tuple[str, ...]  #: files in the folder
    size: int = 0  #: of the frame

    @property
    def fault(self) -> str:
        """Return what is wrong, "" for nothing."""
        if self.code is None:
            return "hangs"
        if self.code == 0:
            return "silent: exit code 0"
        if self.left:
            return f"left behind: {', '.join(self.left)}"
        if "Traceback" in self.errors:
            return f"a traceback: {self.errors.splitlines()[-1]}"
        if self.code != 1 or not any(said in self.errors for said in _SAID):
            return f"exit code {self.code}, and it does not say that the disk is full: {self.errors.strip()[-300:]}"
        return ""


class Frame:
    """A plate and a graph in a folder, to write one frame of a kind again and again; ``size`` is that of the frame."""

    def __init__(self, folder: Path, kind: str) -> None:
        self.kind = kind
        self.plate = folder / "plate.exr"
        self.graph = folder / "copy.json"
        self.out = folder / "out"
        self.out.mkdir()
        noise = oiio.ImageBuf(oiio.ImageSpec(160, 120, 3, oiio.HALF))
        noise.set_pixels(oiio.ROI(), np.random.default_rng(1).random((120, 160, 3), np.float32))
        noise.write(str(self.plate))
        self.graph.write_text(json.dumps(_GRAPH), encoding="utf-8")
        if (whole := self.written(0, None)).code:
            raise RuntimeError(whole.errors)
        self.size = whole.size

    @property
    def name(self) -> str:
        """Return the name of the frame."""
        return f"frame{KINDS[self.kind][0]}"

    def written(self, short: int, most: int | None) -> Outcome:
        """Write the frame, with a file of at most ``most`` bytes, and say what became of it."""

        def limit() -> None:
            if most is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

        command = [sys.executable, "-m", "flowabs_nodes", "run", str(self.graph), "-q", "-i", str(self.plate)]
        command += ["-o", str(self.out / self.name), "--set", f"out.compression={KINDS[self.kind][1]}"]
        environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, env=environment, timeout=PATIENCE, preexec_fn=limit
            )
        except subprocess.TimeoutExpired:
            return Outcome(self.kind, short, None, "", ())
        frame, left = self.out / self.name, tuple(sorted(os.listdir(self.out)))
        size = frame.stat().st_size if frame.exists() else 0
        for name in left:
            (self.out / name).unlink()
        return Outcome(self.kind, short, done.returncode, done.stderr, left, size)

    def with_a_limit(self, short: int) -> Outcome:
        """Write the frame where a file may only hold ``short`` bytes less than it has."""
        return self.written(short, max(0, self.size - short))

    def on_a_small_disk(self, short: int) -> Outcome:
        """Write the frame to a disk that has no room for about ``short`` bytes, at least one page, of it."""
        pages = -(-self.size // _PAGE) + 1  # the frame, and who writes it
        with mounted(self.out, max(1, pages - -(-short // _PAGE)) * _PAGE):
            return self.written(short, None)


@contextmanager
def mounted(folder: Path, size: int) -> Iterator[None]:
    """Mount an empty disk of ``size`` bytes at a folder. Raises PermissionError where that is not allowed."""
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (subprocess.CalledProcessError, OSError) as error:
        raise PermissionError("no disk may be mounted here") from error
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True, capture_output=True)


def shortfalls(size: int, times: int, chance: random.Random) -> list[int]:
    """Return so many numbers of bytes that a frame of ``size`` may lack: first the smallest and the largest."""
    first = [1, size, 2, size - 1, size - 400, size // 2]
    return (first + [chance.randrange(1, size) for _ in range(times)])[:times]


def main() -> int:
    """Fill many disks; return 1 if anything was wrong once."""
    parser = argparse.ArgumentParser(prog="python -m tools.reliability.full_disk", description=__doc__)
    parser.add_argument("--times", type=int, default=50, help="shortfalls of each kind of file, and way (50)")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    outcomes: list[Outcome] = []
    disks = True
    for kind in KINDS:
        with tempfile.TemporaryDirectory() as name:
            frame = Frame(Path(name), kind)
            for short in shortfalls(frame.size, given.times, chance):
                outcomes.append(frame.with_a_limit(short))
                try:
                    if disks:
                        outcomes.append(frame.on_a_small_disk(short))
                except PermissionError as error:
                    disks = False
                    print(f"{error}: limits on files only")
    for outcome in outcomes:
        if outcome.fault:
            print(f"{outcome.kind}, {outcome.short} bytes short: {outcome.fault}")
    faults = sum(bool(outcome.fault) for outcome in outcomes)
    print(f"{len(outcomes)} full disks, {faults} faults")
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
