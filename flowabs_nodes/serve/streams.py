"""The streams of the server's process: whoever prints on stdout, the protocol alone is read there."""

from __future__ import annotations

import os
import stat
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import NamedTuple

from flowabs_nodes.serve.framing import ByteStream


class HostStreams(NamedTuple):
    """What the host writes, what it reads, and whether it would be heard of if it died: its end of a pipe closes."""

    reads: ByteStream
    writes: ByteStream
    piped: bool


def host_streams() -> HostStreams:
    """Take stdin and stdout for the protocol: from now on what this process prints, C libraries too, is on stderr."""
    reads, writes = os.dup(0), os.dup(1)
    mode = os.fstat(reads).st_mode
    sys.stdout.flush()
    nowhere = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nowhere, 0)
    os.close(nowhere)
    os.dup2(2, 1)
    if sys.platform == "win32":
        import msvcrt

        msvcrt.setmode(reads, os.O_BINARY)
        msvcrt.setmode(writes, os.O_BINARY)
    piped = stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)
    return HostStreams(open(reads, "rb", buffering=0), open(writes, "wb", buffering=0), piped)


def watch_end(stream: ByteStream, ended: Callable[[], None]) -> None:
    """Have ``ended`` called, in a thread, where the stream ends; what comes on it until then is passed over."""

    def watch() -> None:
        with suppress(OSError):
            while stream.readinto(memoryview(bytearray(4096))):
                pass
        ended()

    threading.Thread(target=watch, name="flowabs-host", daemon=True).start()
