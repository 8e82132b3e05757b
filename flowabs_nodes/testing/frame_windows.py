"""Checks of a node that reads other frames of its inputs."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Container, Iterable, Mapping
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import graph as graphs
from flowabs_nodes.array_types import Array
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_sequence import render_sequence
from flowabs_nodes.image import Image, PortType
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Port
from flowabs_nodes.nodes.frame_offsets import MAX_DISTANCE, frame_offsets
from flowabs_nodes.testing.parameters import alternatives
from flowabs_nodes.testing.pictures import SCENES, make_input, on_frame
from flowabs_nodes.testing.running import finite, inputs_of, require

_FRAMES = (1, 2, 3, 4, 5, 6)
_ANOTHER_ORDER = (4, 1, 6, 2, 3, 5)

#: The offsets of frames that are there, by where a window is cut like this.
_CUT: Mapping[str, Container[int]] = {
    "on the first frame": range(MAX_DISTANCE + 1),
    "on the last frame": range(-MAX_DISTANCE, 1),
    "on a single frame": (0,),
    "where the next frame is missing": {*range(-MAX_DISTANCE, MAX_DISTANCE + 1)} - {1},
}


def asks_by_the_rules(node: Node) -> None:
    """Check that ``frames`` returns what it may, beside the defaults and each other value of a parameter."""
    frame_offsets(node, node.defaults())
    for param in node.all_params.values():
        for value in alternatives(param):
            frame_offsets(node, node.defaults() | {param.name: value})


def takes_windows_that_are_cut(node: Node) -> None:
    """Check that outputs are finite at both ends of a sequence, on a single frame, and with a hole in the window."""
    offsets = frame_offsets(node, node.defaults())
    for scene in SCENES:
        inputs = inputs_of(node, scene)
        for where, there in _CUT.items():
            cut = {
                name: {each: on_frame(inputs[name], each) for each in offsets[name] if each in there}
                for name in offsets.keys() & inputs.keys()
            }
            for name, image in call_node(node, Context(node=node.type), {**inputs, **cut}, {}).items():
                require(finite(image), f"{scene}: output {name!r} is not finite {where}")


def same_in_any_order(node: Node) -> None:
    """Check that a frame has the same bits alone, in a run and in another order; inputs are computed once in a run."""
    calls: Counter[tuple[str, int]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        alone: list[Array] = []
        for frame in _FRAMES:
            alone += _run(node, os.path.join(folder, "alone"), [frame], Counter())
        for order in (_FRAMES, _ANOTHER_ORDER):
            calls.clear()
            found = _run(node, os.path.join(folder, f"from_{order[0]}"), order, calls)
            for frame, one, other in zip(_FRAMES, alone, found, strict=True):
                same = np.array_equal(one, other, equal_nan=True)
                require(same, f"frame {frame} differs between a run of that frame and one of {order}")
            require(max(calls.values(), default=1) == 1, f"an input is computed several times in a run of {order}")


def _run(node: Node, folder: str, frames: Iterable[int], calls: Counter[tuple[str, int]]) -> list[Array]:
    """Run the node on ``frames`` with made pictures as its inputs, all of its outputs written; return their pixels.

    ``calls`` counts how often each input was made, by its name and frame.
    """
    sources = {port.name: _source(port.accepts[0], calls) for port in node.inputs}
    nodes: dict[str, Any] = {f"in_{name}": {"type": source.name} for name, source in sources.items()}
    nodes["node"] = {"type": node.name, "inputs": {name: f"in_{name}" for name in sources}}
    first, *others = node.all_outputs
    layers = {"image": f"node.{first}"} | {f"layer_{name}": f"node.{name}" for name in others}
    nodes["out"] = {"type": "write@1", "inputs": layers, "params": {"data_type": "float"}}
    known = catalogue() | {each.type: each for each in (*sources.values(), node)}
    graph = graphs.load({"format": "flowabs.graph/1", "name": "suite", "nodes": nodes}, known)
    options = RunOptions(output=os.path.join(folder, "out.####.exr"), frames=frames)
    for report in render_sequence(graph, options).frames:
        if report.error is not None:
            raise report.error
    buffers = [oiio.ImageBuf(os.path.join(folder, f"out.{frame:04d}.exr")) for frame in sorted(frames)]
    return [np.asarray(buffer.get_pixels(oiio.FLOAT)) for buffer in buffers]


def _source(kind: PortType, calls: Counter[tuple[str, int]]) -> Node:
    """Return a node without inputs that makes a picture of a port type, another one on each frame."""

    def run(context: Context) -> Image:
        calls[context.node, context.frame] += 1
        return on_frame(make_input(kind, "shapes", 20, 24), context.frame)

    return Node(f"suite_{kind}", 1, f"A picture of type {kind}.", (), (Port("image", kind, "It."),), (), run)
