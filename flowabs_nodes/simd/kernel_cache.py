"""Compiled kernels, kept on disk from one process to the next.

numba's own cache looks at the file of a function alone. A kernel consists of functions of several files, so here all
of the package's sources together are its version; and each kernel and signature is one file, written whole or not at
all, so that processes on any machines may fill the same folder at once.

Kernels are looked for, and written, in

- ``NUMBA_CACHE_DIR`` alone, where it is set;
- else ``__pycache__`` of the package: a read-only install brings its kernels along if it was run once while writable;
- else the user's cache folder (``XDG_CACHE_HOME``, ``~/Library/Caches``, ``%LOCALAPPDATA%``).

Where nothing can be written, kernels are compiled in each process; the log says so once.
"""

from __future__ import annotations

import hashlib
import logging
import os
import pickle
import shutil
import sys
import uuid
import zlib
from collections.abc import Callable
from functools import cache
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import llvmlite  # type: ignore[import-untyped]
import numba
from numba.core import config
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from flowabs_nodes.simd import compile_hooks
from flowabs_nodes.simd.target import PATH

PACKAGE = "flowabs_nodes"
KEPT = 4  # folders of other versions and settings that stay beside the one in use, the latest used

log = logging.getLogger("flowabs")


class KernelCache(_Cache):  # type: ignore[misc]
    """What numba asks for compiled code of one function, and gives it to."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__.removeprefix(f'{PACKAGE}.')}.{function.__qualname__}"
        self._enclosed = dumps([cell.cell_contents for cell in function.__closure__ or ()])

    @property
    def cache_path(self) -> str:
        """Where the kernel is looked for first."""
        return str(folders()[0]) if folders() else ""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel of a signature; None if it has to be compiled."""
        # Not target_context.refresh(), as numba's cache does: that imports half of numba, which only compiling needs.
        rtsys.initialize(target_context)
        name = self._file(sig, target_context.codegen())
        for folder in folders():
            found = _read(folder / name)
            if found is not None and found[0] == sig:
                return CompileResult._rebuild(target_context, *found[1])
        compile_hooks.tell()
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a kernel that was compiled just now. Never fails."""
        if data.library.has_dynamic_globals:  # addresses of this process
            log.warning("the kernel %s cannot be kept: it refers to memory of this process", self._name)
        else:
            *content, environments = data._replace(type_annotation="")._reduce()  # the annotation is long, for people
            # One without constants is of no use, but loading it would import the module of numba that it is of.
            content.append(tuple(each for each in environments if each.consts))
            _keep(self._file(sig, data.codegen), dumps((sig, content)))

    def enable(self) -> None:
        """Always on."""

    def disable(self) -> None:
        """Always on."""

    def flush(self) -> None:
        """Nothing to forget: another version is another folder."""

    def _file(self, sig: Any, codegen: Any) -> str:
        key = repr((str(sig), codegen.magic_tuple(), self._enclosed)).encode()  # the second: processor and features
        return f"{self._name}-{hashlib.sha256(key).hexdigest()[:16]}.kernel".replace("<locals>.", "")


def _sources(folder: Traversable) -> list[tuple[str, bytes]]:
    """Name and content of every source below a folder, which may be inside of an archive."""
    found = []
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            found += _sources(entry) if entry.name != "__pycache__" else []
        elif entry.name.endswith((".py", ".pyc")):
            found.append((entry.name, entry.read_bytes()))
    return found


def _version() -> str:
    """Of everything that kernels are made of and by; "" where no sources are to be seen."""
    try:
        sources = [(source.name, source.read_bytes()) for source in sorted((Path(__file__).parents[1]).rglob("*.py"))]
    except OSError:
        return ""
    tools = (PATH, numba.__version__, llvmlite.__version__, sys.version, sys.platform)
    return hashlib.sha256(pickle.dumps((sources, tools))).hexdigest()[:16] if sources else ""


VERSION = _version()  # now: of what is imported, should a file change while this process runs


def folders() -> list[Path]:
    """Where kernels of this version are looked for, in this order."""
    if not VERSION:
        return []
    if config.CACHE_DIR:
        homes = [Path(config.CACHE_DIR, "flowabs")]
    else:
        homes = [Path(__file__).parents[1] / "__pycache__", user_folder() / "flowabs"]
    return [home / f"kernels-{VERSION}" for home in homes if home.is_absolute() or config.CACHE_DIR]


def user_folder() -> Path:
    """Where programs of the user keep what they can make again; relative where the user has no home."""
    home = Path(os.path.expanduser("~"))
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local")
    if sys.platform == "darwin":
        return home / "Library" / "Caches"
    given = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return given if given.is_absolute() else home / ".cache"


def _read(file: Path) -> Any:
    try:
        content = file.read_bytes()
    except OSError:
        return None
    check, data = content[:4], content[4:]
    return pickle.loads(data) if check == _checksum(data) else None


def _keep(name: str, data: bytes) -> None:
    """Write a file into the first folder that takes it."""
    problems = []
    for folder in folders():
        try:
            _write(folder, name, _checksum(data) + data)
        except OSError as problem:
            problems.append(str(problem))
        else:
            return
    _warn("; ".join(problems))


def _write(folder: Path, name: str, content: bytes) -> None:
    if not folder.exists():
        folder.mkdir(parents=True, exist_ok=True)
        _sweep(folder)
    new = folder / f"{uuid.uuid4().hex}.tmp"
    try:
        new.write_bytes(content)
        new.replace(folder / name)
    except OSError:
        new.unlink(missing_ok=True)
        raise


@cache
def _warn(problems: str) -> None:
    log.warning("compiled kernels cannot be kept, each process compiles them again: %s", problems)


def _checksum(data: bytes) -> bytes:
    return zlib.crc32(data).to_bytes(4, "little")


def _sweep(new: Path) -> None:
    """Remove folders of former versions, but for the latest."""
    others = [folder for folder in new.parent.glob("kernels-*") if folder != new]
    others.sort(key=lambda folder: folder.stat().st_mtime)
    for old in others[:-KEPT]:
        shutil.rmtree(old, ignore_errors=True)
