"""Where the colour space of a file comes from (DESIGN 10)."""

from __future__ import annotations

from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.color.spaces import ColorSpace, space


class Detected(NamedTuple):
    """A file's scene-linear space, how it was found (a sentence for the log), and its encoding if that is not linear."""

    space: ColorSpace
    how: str
    encoding: str | None = None


def detect(spec: oiio.ImageSpec, given: str = "auto", ocio: str | None = None, default: str = "lin_rec709") -> Detected:
    """The colour space of a file with this header."""
    if given != "auto":
        return Detected(space(given), f"given: {given}")
    return Detected(space(default), f"no tag in the file: {default}")
