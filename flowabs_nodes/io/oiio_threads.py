"""Limit the threads of OpenImageIO, which are of the whole process, for as long as frames are rendered."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import OpenImageIO as oiio

_SETTINGS = ("threads", "exr_threads")


@contextmanager
def limited_oiio(threads: int) -> Iterator[None]:
    """Inside, OpenImageIO decodes and computes with so many threads, in this process and for everybody in it."""
    before = {name: oiio.get_int_attribute(name) for name in _SETTINGS}
    try:
        for name in _SETTINGS:
            oiio.attribute(name, threads)
        yield
    finally:
        for name, value in before.items():
            oiio.attribute(name, value)
