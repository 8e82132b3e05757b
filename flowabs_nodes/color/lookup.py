"""Find a scene-linear space by any of its names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flowabs_nodes.color.spaces import KNOWN, STANDARD, ColorSpace, known
from flowabs_nodes.errors import ColorError, nearest

if TYPE_CHECKING:
    from flowabs_nodes.color.config import Ocio


def space(value: ColorSpace | str, ocio: Ocio = None) -> ColorSpace:
    """Return the scene-linear space of a name.

    Parameters
    ----------
    value
        A :class:`ColorSpace` (returned as it is), a known name or alias (any case), "chromaticities(...)", or any
        scene-linear space of the OCIO config.
    ocio
        The OCIO config that names are looked up in, before the known names but for the Color Interop Forum's, which
        mean the same in every config. None is the pinned one.

    Raises
    ------
    ColorError
        If there is no such space, or it is not scene-linear. The hint is the nearest name.
    """
    if isinstance(value, ColorSpace):
        return value
    if not isinstance(value, str) or not value:
        raise ColorError(f"{value!r} is not the name of a colour space", hint=nearest(value, KNOWN))
    name = known(value) if ocio is None or value in STANDARD else None
    if name is not None:
        return KNOWN[name]
    from flowabs_nodes.color import named  # imports OpenImageIO, which known spaces do not need

    found = named.find(value, ocio)
    if found.kind != "linear":
        kind = "holds data, not colour" if found.kind == "data" else "is not scene-linear RGB"
        raise ColorError(f"the colour space {value!r} {kind}", hint=f"scene-linear spaces: {', '.join(KNOWN)}")
    return found.space
