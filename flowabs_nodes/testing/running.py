"""Runs a node on the suite's pictures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node
from flowabs_nodes.nodes.frame_offsets import frame_offsets
from flowabs_nodes.testing.pictures import make_input, on_frame


class ComplianceError(AssertionError):
    """Says that a node does not do what every node should."""


def require(holds: bool, otherwise: str) -> None:
    """Raise :class:`ComplianceError`, with what is ``otherwise`` the case, unless it holds."""
    if not holds:
        raise ComplianceError(otherwise)


def run_node(
    node: Node, inputs: Mapping[str, Image], params: Mapping[str, Any] | None = None, wanted: str = "", frame: int = 6
) -> dict[str, Image]:
    """Return the node's outputs, all or the one wanted, decoded, with defaults for what ``params`` leaves out.

    ``frame`` is one on which what changes every few frames has changed, however many these are by default. Of an input
    that the node reads on several frames, the other frames are made from its image (:func:`on_frame`).
    """
    context = Context(frame=frame, node=node.type, wanted=frozenset({wanted} if wanted else ()))
    with error_boundary(node.type):
        offsets = frame_offsets(node, node.defaults() | dict(params or {}))
    windows = {
        name: {offset: on_frame(inputs[name], offset) for offset in offsets[name]} for name in offsets if name in inputs
    }
    outputs = call_node(node, context, {**inputs, **windows}, params or {})
    return {name: image.decoded() for name, image in outputs.items()}


def inputs_of(node: Node, scene: str, height: int = 20, width: int = 24, optional: bool = True) -> dict[str, Image]:
    """Make an image for each declared input but the mask, each of the first type its port takes.

    Without the ``optional`` ones there is still the first of those of which a node needs one.
    """
    return {
        port.name: make_input(port.accepts[0], scene, height, width)
        for port in node.inputs
        if optional or not port.optional or port.name in node.one_of[:1]
    }


def equal(a: Image, b: Image) -> bool:
    """Return True if both images have the same type and the same bits."""
    return a.type == b.type and np.array_equal(a.pixels, b.pixels, equal_nan=True)


def finite(image: Image) -> bool:
    """Return True if the image has neither NaN nor Inf."""
    return bool(np.isfinite(image.pixels).all())
