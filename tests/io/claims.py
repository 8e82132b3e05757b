"""Makes claims of other writers: living ones in processes of their own, and what dead ones left."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from flowabs_nodes.io.claim_files import Writer, claim_path, temporary_path

HOLD = """
import os, sys
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io import claim_files
with claim(sys.argv[1]) as held:
    held.write(b"half a fr")
    print("holding", flush=True)
    sys.stdin.readline()
    held.publish()
"""

#: A reach that no process of this machine has.
ELSEWHERE = "1" * 8


class Clock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


def holder(path: Path) -> subprocess.Popen[str]:
    """Start another process, which holds a claim until it reads a line."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdin=-1, stdout=-1, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "holding\n"
    return process


def left_by(final: Path, host: str = "elsewhere", token: str = ELSEWHERE + "ab" * 5, pid: int = 1) -> Writer:
    """Write the two files of a claim that nobody holds."""
    writer = Writer(host, token, pid)
    claim_path(final).write_text(f"{host} {token} {pid}\n")
    temporary_path(final, writer).write_bytes(b"half")
    return writer


def touched(path: Path) -> None:
    """Change a file's time, backwards, as a host with a slow clock would."""
    time = os.stat(path).st_mtime_ns - 3_600_000_000_000
    os.utime(path, ns=(time, time))


def left(folder: Path) -> list[str]:
    """Return the names of the files that are left in a folder."""
    return sorted(os.listdir(folder))
