"""Scales lengths with the picture's size.

A graph that says ``"reference_size": {"shorter": 1080}`` means its pixel lengths for a display window whose shorter
side has 1080 pixels: on another plate they are multiplied by ``shorter side / 1080``, quantities per pixel divided by
it. ``--scale 0.5`` makes the pictures that come in smaller (:mod:`flowabs_nodes.engine.resize`); lengths follow,
because the display window does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.report import Note
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Node, Param

if TYPE_CHECKING:
    from flowabs_nodes.graph.reference_size import ReferenceSize


def length_factor(reference_size: ReferenceSize | None, scale: float, image: Image | None) -> float:
    """Return the factor by which a node's lengths grow.

    Parameters
    ----------
    reference_size
        The size of the display window that the graph's lengths are meant for; None: lengths follow
        ``scale`` alone.
    scale
        The ``--scale`` of the run.
    image
        The picture that the node looks at, already resized by ``scale``; None for a node without inputs.
    """
    if reference_size is None or image is None:
        return scale
    return reference_size.factor(image.display_window.width, image.display_window.height)


def has_lengths(declaration: Node) -> bool:
    """Return True for a node some of whose parameters follow the size of the picture."""
    return any(param.scales for param in declaration.all_params.values())


def scale_lengths(
    declaration: Node, params: Mapping[str, Any], factor: float, run_scale: float | None = None
) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """Multiply lengths by ``factor``, divide quantities per pixel by it, and say what is to be known of it.

    Sizes of pictures, which no reference size changes, are multiplied by ``run_scale``, the ``--scale`` of the run
    (``factor`` without it), and stay whole.

    A scaled value outside the parameter's hard range becomes the range's end, with a warning. Scaling shortens no
    length below the parameter's ``floor``, and warns where it would: a line filter of a fraction of a pixel sees no
    edge. A length that the graph itself gives below the floor is not made longer. A length scaled below the parameter's
    ``thin_below`` is kept, and a note says so.

    Returns
    -------
    tuple
        All parameters, scaled where they scale; notes and warnings, each to be given once in a run, one a parameter.
    """
    scaled = dict(params)
    notes = []
    for name, param in declaration.all_params.items():
        value = scaled.get(name)
        if param.scales and isinstance(value, list | tuple):
            scaled[name] = _scaled_list(param, value, factor if run_scale is None or not param.of_run else run_scale)
            continue
        if not param.scales or factor == 1 or isinstance(value, bool) or not isinstance(value, int | float):
            continue
        wanted = value * factor**param.scales
        inside, least = _within(param, wanted), min(param.floor or 0, value)
        scaled[name] = fitting = max(inside, least)
        times = f"{name} {value:g} x {factor**param.scales:.3g} = {wanted:.3g}"
        if inside < least:
            notes.append(Note(f"{times} px is too short at this size: {least:g} px used", warning=True, once=name))
        elif fitting != wanted and not (param.kind == "int" and abs(fitting - wanted) <= 0.5):
            notes.append(Note(f"{times} is not {param.range_text}: {fitting:g} used", warning=True, once=name))
        elif param.thin_below is not None and fitting < param.thin_below:
            thin = f"{name} is {fitting:.3g} px at this size: below {param.thin_below:g}, "
            notes.append(Note(thin + "lines change with the picture's size", once=name))
    return scaled, tuple(notes)


def _scaled_list(param: Param, values: Sequence[float], factor: float) -> Sequence[float]:
    """Return a list of lengths times ``factor``; the sides of a picture, which are whole, are at least 1."""
    if factor == 1:
        return values
    if param.of_run:
        return [max(1, math.floor(value * factor + 0.5)) for value in values]
    return [value * factor**param.scales for value in values]


def _within(param: Param, value: float) -> float:
    """Return ``value`` moved into the hard range of ``param``, and rounded for whole numbers."""
    if param.kind == "int":
        value = math.floor(value + 0.5)
    if param.max is not None:
        value = min(value, param.max)
    if param.min is not None and value <= param.min:
        value = math.nextafter(param.min, math.inf) if param.above else param.min
    return int(value) if param.kind == "int" else value
