"""Lengths that follow the picture's size.

A graph that says ``"reference_height": 1080`` means its pixel lengths for a display window of that height: on another
plate they are multiplied by ``display height / reference height``, quantities per pixel divided by it. ``--scale 0.5``
makes the pictures that come in smaller (:mod:`flowabs_nodes.engine.resize`); lengths follow, because the display window
does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from flowabs_nodes.engine.report import Note
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node, Param


def check_scale(scale: Any) -> float:
    """``scale`` as a float above 0 up to 1."""
    if isinstance(scale, bool) or not isinstance(scale, int | float) or not 0 < scale <= 1:
        raise ArgumentError(f"scale: expected a number above 0 up to 1, found {scale!r}", parameter="scale")
    return float(scale)


def length_factor(reference_height: float | None, scale: float, image: Image | None) -> float:
    """By how much a node's lengths grow: ``image`` is what it looks at, already resized by ``scale``."""
    if reference_height is None or image is None:
        return scale
    return image.display_window.height / reference_height


def has_lengths(declaration: Node) -> bool:
    """True for a node some of whose parameters follow the size of the picture."""
    return any(param.scales for param in declaration.all_params.values())


def scale_lengths(
    declaration: Node, params: Mapping[str, Any], factor: float
) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """Parameters with lengths multiplied by ``factor`` and quantities per pixel divided by it, and what to warn of.

    A scaled value outside the parameter's hard range becomes the range's end.
    """
    scaled = dict(params)
    warnings = []
    for name, param in declaration.all_params.items():
        value = scaled.get(name)
        if not param.scales or factor == 1 or isinstance(value, bool) or not isinstance(value, int | float):
            continue
        wanted = value * factor**param.scales
        scaled[name] = fitting = _within(param, wanted)
        if fitting != wanted and not (param.kind == "int" and abs(fitting - wanted) <= 0.5):
            text = (
                f"{name} {value:g} x {factor**param.scales:g} = {wanted:g} is not {param.range_text}: {fitting:g} used"
            )
            warnings.append(Note(text, warning=True, once=f"range {name}"))
        if name == "sigma_c" and fitting < 1:
            text = f"sigma_c is {fitting:.3g} px at this size: below 1, lines change with the picture's size"
            warnings.append(Note(text, warning=True, once="sigma_c"))
    return scaled, tuple(warnings)


def _within(param: Param, value: float) -> float:
    if param.kind == "int":
        value = math.floor(value + 0.5)
    if param.max is not None:
        value = min(value, param.max)
    if param.min is not None and value <= param.min:
        value = math.nextafter(param.min, math.inf) if param.above else param.min
    return int(value) if param.kind == "int" else value
