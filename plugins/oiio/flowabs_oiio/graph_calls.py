"""Runs a whole graph on ImageBufs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import OpenImageIO as oiio

from flowabs_nodes.engine.plan import file_role, output_names
from flowabs_nodes.engine.runnable import RunnableGraph, load_graph
from flowabs_nodes.errors import CommandError
from flowabs_nodes.image import Image
from flowabs_oiio.calls import delivered


def run(
    graph: str | Path | Mapping[str, Any] | RunnableGraph,
    src: oiio.ImageBuf | Mapping[str, oiio.ImageBuf],
    *,
    output: str = "",
    frame: int = 1,
    scale: float = 1.0,
    dst: oiio.ImageBuf | None = None,
    roi: oiio.ROI | None = None,
    nthreads: int = 0,
    **knobs: Any,
) -> oiio.ImageBuf | bool:
    """Run a graph: ``run("abstraction", src, line_width=1.5)``.

    Parameters
    ----------
    graph
        A path, the name of a graph that comes with flowabs, its content as a dict, or one that is loaded.
    src
        The plate, for the graph's first ``read`` node; or a dict from outputs, such as "plate", to what stands in.
    output
        What to compute, "node" or "node.output"; without it, what the graph writes.
    frame
        The frame's number, for curves and for files that the graph reads beside the plate.
    scale
        Above 0 up to 1: filters a smaller picture, with lengths to match.
    dst, roi, nthreads
        As for the functions of single nodes.
    knobs
        Values of the graph's knobs.

    Returns
    -------
    An ImageBuf; with ``dst``, whether it was filled. Whatever is wrong with the graph, the pictures or the knobs is the
    ImageBuf's error, and that of ``flowabs_oiio.geterror()``.
    """

    def compute() -> Image:
        loaded = load_graph(graph)
        given = src if isinstance(src, Mapping) else {_plate(loaded): src}
        name = output or output_names(loaded, None)[0]
        return loaded.run(frame, given, set=knobs, outputs=name, scale=scale)[name]

    return delivered("run", compute, dst, roi, nthreads)


def _plate(graph: RunnableGraph) -> str:
    """Return the name of the graph's first node that reads a picture.

    Raises
    ------
    CommandError
        no-read: it has none.
    """
    for name in graph.nodes:
        if file_role(graph, name) == "input":
            return name
    raise CommandError("the graph reads no picture", code="no-read", hint='say what src stands in for: {"node": src}')
