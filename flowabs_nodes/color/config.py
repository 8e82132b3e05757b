"""OCIO configs, by way of OpenImageIO's ColorConfig: find a config, look up its names, convert pixels with it.

The functions take a config as ``ocio``: a path or an "ocio://..." name, or None for the pinned config. ``$OCIO`` is
never read, so that a run means the same on every machine.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ColorError, nearest

#: Built into OpenColorIO since 2.4 (OpenImageIO 3.0): the ACES spaces, the lin_* names of the Color Interop Forum,
#: cameras.
PINNED = "ocio://studio-config-v2.2.0_aces-v1.3_ocio-v2.4"

#: Spaces through which a config is tied to CIE XYZ, the first that it has: its name for the space, and ours.
_REFERENCES = (
    ("lin_ap0_scene", "lin_ap0_scene"),
    ("ACES2065-1", "lin_ap0_scene"),
    ("aces_interchange", "lin_ap0_scene"),
    ("lin_ap1_scene", "lin_ap1_scene"),
    ("ACEScg", "lin_ap1_scene"),
    ("lin_rec709_scene", "lin_rec709"),
    ("lin_rec709", "lin_rec709"),
)


@cache
def config(ocio: str | None = None) -> Any:
    """Return the ColorConfig of that path or "ocio://..." name; the pinned one for None.

    Raises ColorError where the config cannot be read: OpenImageIO itself would fall back to a dozen built-in spaces and
    only leave a message.
    """
    name = ocio or PINNED
    found = oiio.ColorConfig(name)
    problem = said(found.geterror)
    if problem or found.configname() == "built-in":
        raise ColorError(
            f"the OCIO config {name!r} cannot be read: {problem or 'no reason given'}",
            code="bad-ocio-config",
            hint=f"without one, {PINNED} is used",
        )
    return found


def has(name: str, ocio: str | None = None) -> bool:
    """Return whether the config knows a name, alias or role."""
    return bool(config(ocio).getColorSpaceIndex(name) >= 0)


def canonical(name: str, ocio: str | None = None) -> str:
    """Return the config's own name for a space, alias or role."""
    return str(config(ocio).resolve(name))


def names(ocio: str | None = None) -> list[str]:
    """Return every name and alias of the config, for hints."""
    found = config(ocio)
    spaces = [str(space) for space in found.getColorSpaceNames()]
    return [*spaces, *(str(alias) for space in spaces for alias in found.getAliases(space))]


@cache
def reference(ocio: str | None = None) -> tuple[str, str]:
    """Return a scene-linear space of the config whose primaries are known here: its name in the config, and ours."""
    for theirs, ours in _REFERENCES:
        if has(theirs, ocio):
            return theirs, ours
    raise ColorError(
        f"the OCIO config {ocio!r} has neither ACES2065-1, ACEScg nor lin_rec709, so its colours cannot be placed",
        code="bad-ocio-config",
    )


def convert(pixels: Array, source: str, target: str, ocio: str | None = None) -> Array:
    """Convert (H, W, 3 or 4) float32 between spaces of the config; alpha stays, nothing is unpremultiplied."""
    config(ocio)  # raises for a config that cannot be read, in whose place OpenImageIO would use another
    buf = oiio.ImageBuf(np.ascontiguousarray(pixels, np.float32))
    result = oiio.ImageBufAlgo.colorconvert(buf, source, target, unpremult=False, colorconfig=ocio or PINNED)
    if result.has_error:
        raise ColorError(f"no conversion from {source!r} to {target!r}: {said(result.geterror)}")
    converted = result.get_pixels(oiio.FLOAT)
    return np.asarray(converted, np.float32).reshape(pixels.shape)


def said(geterror: Callable[[], str]) -> str:
    """Return OpenImageIO's message, also where it holds bytes that are no UTF-8, which makes ``geterror`` raise."""
    try:
        return str(geterror())
    except UnicodeDecodeError:
        return "a message that is not UTF-8"


def hint(name: str, known: list[str]) -> str:
    """Return a hint with the nearest of the ``known`` names, or "" where none is near: they are too many to list."""
    text = nearest(name, known)
    return text if text.startswith("did you mean") else ""
