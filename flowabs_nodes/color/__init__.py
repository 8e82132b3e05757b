"""Encode pictures as code values, and tell the colour space of a file.

Each name is imported on first use, so that importing this package imports neither numba nor OpenImageIO.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from flowabs_nodes.choices import SPACES

if TYPE_CHECKING:
    from flowabs_nodes.color import ocio
    from flowabs_nodes.color.chromaticities import chromaticities_of, space_from_chromaticities
    from flowabs_nodes.color.codes import decode, encode, encode_mono
    from flowabs_nodes.color.detection import Detected, detect
    from flowabs_nodes.color.lightness import lstar, lstar_inverse, luminance
    from flowabs_nodes.color.lookup import space
    from flowabs_nodes.color.spaces import ColorSpace

#: The module of each public name.
_HOMES = {
    "ColorSpace": "spaces",
    "Detected": "detection",
    "chromaticities_of": "chromaticities",
    "decode": "codes",
    "detect": "detection",
    "encode": "codes",
    "encode_mono": "codes",
    "lstar": "lightness",
    "lstar_inverse": "lightness",
    "luminance": "lightness",
    "space": "lookup",
    "space_from_chromaticities": "chromaticities",
}

__all__ = [
    "SPACES",
    "ColorSpace",
    "Detected",
    "chromaticities_of",
    "decode",
    "detect",
    "encode",
    "encode_mono",
    "lstar",
    "lstar_inverse",
    "luminance",
    "ocio",
    "space",
    "space_from_chromaticities",
]


if not TYPE_CHECKING:  # a type checker would take any name for Any

    def __getattr__(name: str) -> Any:
        """Import a public name on first use (PEP 562)."""
        if name == "ocio":
            return importlib.import_module(f"{__name__}.ocio")
        if name in _HOMES:
            value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
            globals()[name] = value
            return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
