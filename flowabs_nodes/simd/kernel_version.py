"""What compiled kernels are made of and by, as one hash: the name of the folder that they are kept in.

A kernel consists of functions of several files, and numba looks at the file of the kernel alone. So all sources of the
package count together: whatever line changes, everything is compiled afresh.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import llvmlite  # type: ignore[import-untyped]
import numba
from llvmlite import binding

from flowabs_nodes.simd.target import PATH

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

PACKAGE = "flowabs_nodes"

#: Settings of numba that change nothing in what it compiles.
_NOT_ABOUT_CODE = {"NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS"}


def sources(folder: Traversable, above: str = "") -> Iterator[tuple[str, bytes]]:
    """Yield relative path and content of every source below a folder, in order; it may be inside of an archive."""
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.name.endswith((".py", ".pyc")):
            yield above + entry.name, entry.read_bytes()
        elif entry.name != "__pycache__" and "." not in entry.name and entry.is_dir():
            yield from sources(entry, f"{above}{entry.name}/")


def kernel_version() -> str:
    """Return 16 hexadecimal digits for sources, numba, llvmlite, Python, processor and path; "" without sources."""
    try:
        found = list(sources(_package()))
    except OSError:
        found = []
    tools = (PATH, numba.__version__, llvmlite.__version__, sys.version, sys.platform)
    processor = (binding.get_host_cpu_name(), binding.get_host_cpu_features().flatten())
    told = sorted(
        each for each in os.environ.items() if each[0].startswith("NUMBA_") and each[0] not in _NOT_ABOUT_CODE
    )
    return hashlib.sha256(pickle.dumps((found, tools, processor, told))).hexdigest()[:16] if found else ""


def _package() -> Traversable:
    """Return the package's folder; importlib.resources, which is slow to import, only where it is in an archive."""
    folder = Path(__file__).parents[1]
    if folder.is_dir():
        return folder
    from importlib.resources import files

    return files(PACKAGE)


@cache
def source_times() -> str:
    """Return 8 hexadecimal digits for the times of the sources, by which numba 0.60's own cache knows them."""
    files = sorted(Path(__file__).parents[1].rglob("*.py"))
    return hashlib.sha256(repr([(file.name, file.stat().st_mtime_ns) for file in files]).encode()).hexdigest()[:8]


VERSION = kernel_version()  # now: of what is imported, should a file change while this process runs
