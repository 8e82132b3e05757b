"""Check the parts of a file that nobody asked for: nothing is made of a plate that cannot be read whole.

A plate that was cut short, or copied while it was being written, often has a whole first part. Only decoding finds all
that is wrong with a part, so each is decoded, several at a time.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.limits import check_readable
from flowabs_nodes.io.oiio_error import printable, reason
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.verify import decodes
from flowabs_nodes.simd.bands import thread_count

#: Of how many files it is remembered which parts decode: several nodes of a graph read the same file.
_FILES = 64
#: The parts that decode, by what identifies a file and its state.
_whole: dict[tuple[object, ...], set[int]] = {}


def check_other_parts(path: str, specs: Sequence[oiio.ImageSpec], part: int, settings: Settings) -> None:
    """Raise ReadError where a part other than ``part``, which has been decoded, does not decode. Deep parts are let be.

    Each part of a file is decoded once in a process, 256 rows at a time, and as many parts at a time as kernels have
    threads.
    """
    if len(specs) < 2:
        return
    state = os.stat(path)
    signature = (state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns)
    whole = _whole.setdefault(signature, set())
    while len(_whole) > _FILES:
        _whole.pop(next(iter(_whole)), None)
    whole.add(part)
    others = [other for other in range(len(specs)) if other not in whole and not specs[other].deep]
    for other in others:
        check_readable(path, specs[other], 1, settings)
    for other, problem in zip(others, _problems(path, others), strict=True):
        if problem:
            name = printable(specs[other].get_string_attribute("name") or str(other))
            raise ReadError(f"damaged or cut short, in the part {name!r}: {problem}", code="damaged", file=path)
        whole.add(other)


def _problems(path: str, parts: Sequence[int]) -> list[str]:
    """Decode parts of a file, several at a time; return of each why it does not decode, "" where it does."""
    threads = min(thread_count(), len(parts))
    if threads < 2:
        return [_problem(path, part) for part in parts]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(_problem, [path] * len(parts), parts))


def _problem(path: str, part: int) -> str:
    """Decode a part of a file, which is opened anew: an open one reads one part at a time."""
    source: Any = oiio.ImageInput.open(path)
    if source is None:
        return reason(oiio) or "it cannot be opened again"
    try:
        decoded = source.seek_subimage(part, 0) and decodes(source, source.spec(), part)
        return reason(source) or ("" if decoded else "its pixels cannot be decoded")
    finally:
        source.close()
