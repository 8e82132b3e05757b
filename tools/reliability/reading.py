"""Read files in a child process that may crash, hang or want too much, and say of each what became of it.

As a program, it reads the files that are named on its standard input, and writes a line of JSON after each step.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tools.reliability.runs import CHECKOUT

SECONDS = 5.0
BYTES = 2 << 30


@dataclass(frozen=True)
class Reading:
    """What became of one file.

    ``answer`` is that of our reader: "picture", "refused", "traceback", "hang" or "crash"; ``says`` its error. Of a
    picture, ``others`` names the readers that refuse the file or cannot read all of it: "OpenImageIO", "OpenEXR".
    """

    path: str
    answer: str
    says: str = ""
    seconds: float = 0.0
    others: tuple[str, ...] = ()

    @property
    def fault(self) -> str:
        """Return what is wrong, "" for nothing."""
        if self.answer in ("traceback", "hang", "crash"):
            return f"{self.answer}: {self.says}"
        return f"a picture, from a file that {' and '.join(self.others)} cannot read whole" if self.others else ""


def read_all(paths: Sequence[str | os.PathLike[str]]) -> list[Reading]:
    """Read every file, each within five seconds and two gigabytes; a child that ends before its time is replaced."""
    names = [os.fspath(path) for path in paths]
    readings: list[Reading] = []
    while len(readings) < len(names):
        readings += _read_until_it_ends(names[len(readings) :])
    return readings


def _read_until_it_ends(names: list[str]) -> list[Reading]:
    """Read files in one child, and return the readings up to the file that it ended with."""
    command = [sys.executable, "-m", "tools.reliability.reading"]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    child = subprocess.run(
        command, input=json.dumps(names), capture_output=True, env=environment, text=True, errors="replace"
    )
    lines = [json.loads(line) for line in child.stdout.splitlines()]
    if "began" not in (lines[0] if lines else {}):
        raise RuntimeError(f"the child that reads files did not begin: {child.stderr.strip()[-500:]}")
    readings = [_reading(line) for line in lines[1:] if "others" in line]
    if len(readings) < len(names):
        begun = next((line for line in lines[-1:] if "answer" in line and "others" not in line), None)
        if begun:  # ours has answered: another reader brought the child down
            readings.append(_reading({**begun, "others": ["another reader"]}))
        else:
            hung = child.returncode == -signal.SIGALRM
            says = f"exit code {child.returncode}: {child.stderr.strip()[-300:]}"
            readings.append(Reading(names[len(readings)], "hang" if hung else "crash", says))
    return readings


def _reading(line: dict[str, object]) -> Reading:
    """Return a reading from the child's line."""
    return Reading(**{**line, "others": tuple(line["others"])})  # type: ignore[arg-type]


# ---------------------------------------------------------------------- in the child


def _main() -> None:
    """Read the files named by a JSON list on standard input."""
    from flowabs_nodes.io.read import read_image  # all of it, before memory is counted

    names = json.loads(sys.stdin.read())
    answers = os.fdopen(os.dup(1), "w", buffering=1, encoding="ascii")
    os.dup2(2, 1)  # OpenEXR prints there what is wrong with a file
    size = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (size + BYTES, size + BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGALRM, signal.SIG_DFL)  # which ends the process, in whatever library it is
    print(json.dumps({"began": len(names)}), file=answers)
    for name in names:
        began = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, SECONDS)
        answer, says = _answer(read_image, name)
        line = {"path": name, "answer": answer, "says": says, "seconds": time.monotonic() - began}
        signal.setitimer(signal.ITIMER_REAL, 4 * SECONDS)  # the other readers may take longer
        if answer == "picture":
            print(json.dumps(line), file=answers)
        others = [who for who, reads in OTHERS.items() if not reads(name)] if answer == "picture" else []
        print(json.dumps({**line, "others": others}), file=answers)


def _answer(read: object, name: str) -> tuple[str, str]:
    """Return what our reader makes of a file, and its error."""
    from flowabs_nodes.errors import FlowabsError

    try:
        read(name)  # type: ignore[operator]
    except FlowabsError as error:
        return "refused", str(error)
    except Exception:  # noqa: BLE001 - that is what is looked for
        return "traceback", traceback.format_exc(limit=-2)
    return "picture", ""


def _oiio_reads(name: str) -> bool:
    """Return whether OpenImageIO decodes every pixel of every part."""
    import OpenImageIO as oiio

    source = oiio.ImageInput.open(name)
    part = 0
    if source is not None:
        _complaint(source)  # of a header that it reads all the same
    while source is not None and source.seek_subimage(part, 0):
        if source.spec().deep:
            whole = source.read_native_deep_image(part, 0) is not None
        else:
            whole = source.read_image(part, 0, 0, 10_000, oiio.UNKNOWN) is not None
        if not whole or _complaint(source):
            return False
        part += 1
    return part > 0


def _complaint(source: Any) -> bool:
    """Return whether OpenImageIO has an error to tell, and clear it."""
    try:
        return bool(source.geterror())
    except UnicodeDecodeError:  # it quotes the file
        return True


def _openexr_reads(name: str, attempts: int = 10) -> bool:
    """Return whether OpenEXR reads a file, if it is an EXR. Only its Python module wants names to be UTF-8."""
    import OpenEXR

    if not name.endswith(".exr"):
        return True
    try:
        OpenEXR.File(name)
    except UnicodeDecodeError as error:
        readable = error.object.decode("ascii", "replace").replace("\ufffd", "?").encode("ascii")
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "readable.exr"
            copy.write_bytes(Path(name).read_bytes().replace(error.object, readable, 1))
            return attempts > 0 and _openexr_reads(str(copy), attempts - 1)
    except Exception:  # noqa: BLE001 - it has no family of errors
        return False
    return True


OTHERS = {"OpenImageIO": _oiio_reads, "OpenEXR": _openexr_reads}

if __name__ == "__main__":
    _main()
