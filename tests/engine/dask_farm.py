"""Starts a scheduler of Dask and workers as processes of their own, reached from this machine alone."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


class Farm:
    """A scheduler at ``address``; what it and its workers say is in ``folder``."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start("dask_scheduler", "--port", "0", "--scheduler-file", str(folder / "scheduler"))
        end = time.monotonic() + 60
        while not (folder / "scheduler").exists():
            assert time.monotonic() < end, self.said()
            time.sleep(0.05)
        time.sleep(0.1)
        self.address: str = json.loads((folder / "scheduler").read_text())["address"]

    def worker(self, *words: str, first: Path | None = None) -> subprocess.Popen[bytes]:
        """Start a worker with one thread; what lies in the folder ``first`` is imported before all else."""
        before = sum("Registered to:" in text for text in self.said().values())
        there = [self.address, "--nthreads", "1", "--memory-limit", "0", "--local-directory", str(self.folder)]
        process = self._start("dask_worker", *there, *(words or ("--no-nanny",)), first=first)
        end = time.monotonic() + 60
        while sum("Registered to:" in text for text in self.said().values()) == before:
            assert time.monotonic() < end, self.said()
            time.sleep(0.05)
        return process

    def said(self) -> dict[str, str]:
        """Return what each process has said."""
        return {path.name: path.read_text(errors="replace") for path in self.folder.glob("*.log")}

    def end(self) -> None:
        """End all processes."""
        for process in reversed(self.processes):
            process.terminate()
        for process in self.processes:
            try:
                process.wait(5)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()

    def _start(self, module: str, *words: str, first: Path | None = None) -> subprocess.Popen[bytes]:
        paths = [*([str(first)] if first else []), str(ROOT), os.environ.get("PYTHONPATH", "")]
        how: dict[str, Any] = {"env": {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, paths))}}
        command = [sys.executable, "-m", f"distributed.cli.{module}", *words]
        here = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]
        with open(self.folder / f"{len(self.processes)}.log", "wb") as log:
            process = subprocess.Popen([*command, *here], cwd="/", stdout=log, stderr=log, **how)
        self.processes.append(process)
        return process
