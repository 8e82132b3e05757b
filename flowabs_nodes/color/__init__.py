"""Code values, and where a file's colour space comes from (DESIGN 4.1, 4.2, 10). Importing this imports no kernel."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flowabs_nodes.color.codes import decode, encode, encode_mono
    from flowabs_nodes.color.detection import Detected, detect
    from flowabs_nodes.color.lightness import lstar, lstar_inverse, luminance
    from flowabs_nodes.color.spaces import ColorSpace, space

#: The encodings of code values.
SPACES = ("lab", "acescct")

_HOMES = {
    "decode": "codes",
    "encode": "codes",
    "encode_mono": "codes",
    "Detected": "detection",
    "detect": "detection",
    "lstar": "lightness",
    "lstar_inverse": "lightness",
    "luminance": "lightness",
    "ColorSpace": "spaces",
    "space": "spaces",
}

__all__ = [
    "SPACES",
    "ColorSpace",
    "Detected",
    "decode",
    "detect",
    "encode",
    "encode_mono",
    "lstar",
    "lstar_inverse",
    "luminance",
    "space",
]


def __getattr__(name: str) -> Any:
    if name in _HOMES:
        value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
        globals()[name] = value
        return value
    if name == "ocio":
        return importlib.import_module(f"{__name__}.ocio")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
