"""Check the parts of a file that nobody asked for: nothing is made of a plate that cannot be read whole.

A plate that was cut short, or copied while it was being written, often has a whole first part.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.limits import check_readable
from flowabs_nodes.io.oiio_error import printable, reason
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.verify import decodes

#: Of how many files it is remembered which parts decode: several nodes of a graph read the same file.
_FILES = 64
#: The parts that decode, by what identifies a file and its state.
_whole: dict[tuple[object, ...], set[int]] = {}


def check_other_parts(source: Any, path: str, specs: Sequence[oiio.ImageSpec], part: int, settings: Settings) -> None:
    """Raise ReadError where a part other than ``part``, which has been decoded, does not decode. Deep parts are let be.

    Each part of a file is decoded once in a process, 256 rows at a time.
    """
    if len(specs) < 2:
        return
    state = os.stat(path)
    signature = (state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns)
    whole = _whole.setdefault(signature, set())
    while len(_whole) > _FILES:
        _whole.pop(next(iter(_whole)), None)
    whole.add(part)
    for other in sorted(set(range(len(specs))) - whole):
        if not specs[other].deep:
            check_readable(path, specs[other], 1, settings)
            whole_part = source.seek_subimage(other, 0) and decodes(source, specs[other], other)
            problem = reason(source)
            if problem or not whole_part:
                name = printable(specs[other].get_string_attribute("name") or str(other))
                problem = problem or "its pixels cannot be decoded"
                raise ReadError(f"damaged or cut short, in the part {name!r}: {problem}", code="damaged", file=path)
        whole.add(other)
