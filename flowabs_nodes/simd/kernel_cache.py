"""Compiled kernels, kept on disk from one process to the next.

Each kernel and signature is one file, written whole or not at all, so that processes on any machines may fill the same
folder at once; on one machine they take turns, and each kernel is compiled once. Where numba has changed inside
(:mod:`~flowabs_nodes.simd.numba_internals`), the same folder is left to numba's own cache.

Nothing here ever fails a run. What cannot be loaded, for whatever reason, moves the whole folder away; what cannot be
kept is compiled in each process, and the log says so once.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import uuid
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy.ma  # noqa: F401 - numba asks for it at a kernel's first call, and a fork must not fall into an import
from numba import config, njit

from flowabs_nodes import forks, stopping
from flowabs_nodes.simd import cache_folder, compile_hooks, compile_turn, numba_internals
from flowabs_nodes.simd.kernel_version import PACKAGE, source_times

forks.take_before(*numba_internals.compiler_locks())


def kept(function: Callable[..., Any], **options: Any) -> Any:
    """Return a function of this package as numba compiles it with these options, kept on disk."""
    dispatcher = njit(**options)(function)
    if numba_internals.available(dispatcher):
        dispatcher._cache = OneFileEach(function)
        return dispatcher
    suffix = f"numba-{source_times()}"
    folder = cache_folder.writable(suffix)
    if folder is None or not os.path.exists(function.__code__.co_filename):  # numba would not see what changes in a zip
        return dispatcher
    before, config.CACHE_DIR = config.CACHE_DIR, str(folder)
    try:
        dispatcher = njit(cache=True, **options)(function)
    finally:
        config.CACHE_DIR = before
    if hasattr(dispatcher, "_cache"):
        dispatcher._cache = NumbasOwn(function, dispatcher._cache, suffix)
    return dispatcher


class KernelCache(ABC):
    """What numba asks for the compiled code of one function, and gives it to. Nothing here fails."""

    def __init__(self, function: Callable[..., Any], suffix: str = "") -> None:
        self._suffix = suffix  # of the folder
        name = f"{function.__module__.removeprefix(f'{PACKAGE}.')}.{function.__qualname__}"
        self.name = name.replace("<locals>.", "")

    @property
    def cache_path(self) -> str:
        """Return the folder in which the kernel is looked for first, "" without one."""
        return next((str(place.folder) for place in cache_folder.places()), "")

    def load_overload(self, sig: Any, context: Any) -> Any:
        """Return the compiled kernel of a signature; None if it has to be compiled, by us: others wait for it.

        Raises :class:`~flowabs_nodes.stopping.Stopped` where it would have to be compiled and the work is to end.
        """
        found = self._load(sig, context)
        if found is not None:
            return found
        if (turn := self._turn(sig)) is not None:
            compile_turn.take(turn)
            found = self._load(sig, context)  # somebody else may have compiled it meanwhile
            if found is not None or stopping.any_set(stopping.flags()):
                compile_turn.give(turn)
        if found is None:
            stopping.check()  # compiling takes seconds
            compile_hooks.tell()
        return found

    def save_overload(self, sig: Any, compiled: Any) -> None:
        """Keep a kernel that was compiled just now."""
        try:
            self._save(sig, compiled)
        except Exception as problem:  # noqa: BLE001 - whatever it is, the kernel works
            cache_folder.warn(f"{type(problem).__name__}: {problem}")
        if (turn := self._turn(sig)) is not None:
            compile_turn.give(turn)

    def enable(self) -> None:  # noqa: B027 - numba calls these three
        """Do nothing: the cache is always on."""

    def disable(self) -> None:  # noqa: B027
        """Do nothing: the cache is always on."""

    def flush(self) -> None:  # noqa: B027
        """Do nothing: another version is another folder."""

    def _turn(self, sig: Any) -> Path | None:
        """Return the file whose lock says who compiles a signature; None without a folder."""
        folder = cache_folder.writable(self._suffix)
        signature = hashlib.sha256(str(sig).encode()).hexdigest()[:8]
        return folder / f"{self.name}-{signature}.turn" if folder is not None else None

    @abstractmethod
    def _load(self, sig: Any, context: Any) -> Any:
        """Return the compiled kernel of a signature from disk; None if it is not there. Never raises."""

    @abstractmethod
    def _save(self, sig: Any, compiled: Any) -> None:
        """Write a compiled kernel to disk, if there is a folder; may raise anything."""


class OneFileEach(KernelCache):
    """A checksum and a pickle for each signature, in any folder of this version."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        self._enclosed = numba_internals.enclosed(function)

    def _load(self, sig: Any, context: Any) -> Any:
        numba_internals.prepare(context)
        name = self._file(sig, context.codegen())
        for folder in cache_folder.readable():
            try:
                data = _read(folder / name)
                if data is not None:
                    found, content = pickle.loads(data)
                    if found != sig:
                        raise ValueError(f"{name} holds another kernel")
                    return numba_internals.thaw(content, context)
            except Exception as problem:  # noqa: BLE001 - a damaged pickle may raise anything
                cache_folder.set_aside(folder, problem)
        return None

    def _save(self, sig: Any, compiled: Any) -> None:
        folder = cache_folder.writable()
        if folder is None:
            return
        data = numba_internals.freeze(sig, compiled)
        if data is None:
            raise ValueError(f"{self.name} refers to memory of this process")
        _write(folder / self._file(sig, compiled.codegen), data)

    def _file(self, sig: Any, codegen: Any) -> str:
        key = repr((str(sig), numba_internals.processor(codegen), self._enclosed)).encode()
        return f"{self.name}-{hashlib.sha256(key).hexdigest()[:16]}.kernel"


class NumbasOwn(KernelCache):
    """numba's own cache in a folder of ours."""

    def __init__(self, function: Callable[..., Any], own: Any, suffix: str) -> None:
        super().__init__(function, suffix)
        self._own = own

    def _load(self, sig: Any, context: Any) -> Any:
        try:
            return self._own.load_overload(sig, context)
        except Exception as problem:  # noqa: BLE001 - a damaged pickle may raise anything
            if (folder := cache_folder.writable(self._suffix)) is not None:
                cache_folder.set_aside(folder, problem)
            return None

    def _save(self, sig: Any, compiled: Any) -> None:
        self._own.save_overload(sig, compiled)


def _read(file: Path) -> bytes | None:
    """Return what was written; None where no file of ours is. Raises ValueError where it is damaged."""
    try:
        with open(file, "rb") as opened:
            if not cache_folder.is_ours(os.fstat(opened.fileno())):
                return None
            content = opened.read()
    except OSError:
        return None
    check, data = content[:4], content[4:]
    if check != _checksum(data):
        raise ValueError(f"{file.name} is damaged")
    return data


def _write(file: Path, data: bytes) -> None:
    new = file.with_name(f"{uuid.uuid4().hex}.tmp")
    try:
        with open(new, "wb", opener=lambda path, flags: os.open(path, flags | os.O_EXCL, 0o644)) as opened:
            opened.write(_checksum(data) + data)
        new.replace(file)
    except OSError:
        new.unlink(missing_ok=True)
        raise


def _checksum(data: bytes) -> bytes:
    return (zlib.crc32(data) ^ 0x464C4F57).to_bytes(4, "little")  # so that nothing but zeros is wrong as well
