"""Runs graphs from scripts: ``flowabs_blender.run``."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import bpy

from flowabs_nodes import load_graph
from flowabs_nodes.engine.plan import output_names
from flowabs_nodes.engine.runnable import GraphSource
from flowabs_nodes.errors import CommandError, nearest

from . import fill_datablock
from .background import Background
from .knobs import is_ours
from .outputs import main_outputs
from .picture_run import PictureRun
from .read_datablock import take
from .taken import Taken
from .tree_json import graph_of

log = logging.getLogger("flowabs")


def run(
    graph: bpy.types.NodeTree | GraphSource,
    image: bpy.types.Image | str | os.PathLike[str],
    *,
    outputs: str | Iterable[str] | None = None,
    set: Mapping[str, Any] | None = None,
    frame: int | None = None,
    scale: float = 1.0,
    file: str | os.PathLike[str] | None = None,
    name: str = "",
) -> bpy.types.Image | dict[str, bpy.types.Image]:
    """Run a graph on a picture and return the result as an Image datablock, ready for the compositor.

    ::

        result = flowabs_blender.run("abstraction", bpy.data.images["plate"], set={"line_width": 1.5})

    Parameters
    ----------
    graph
        A node tree or its name; else a graph file, a dict, or the name of a graph that comes with flowabs.
    image
        An Image datablock or its name; else a file, which is read as ``flowabs run -i`` reads it.
    outputs
        What to compute, "node" or "node.output": one name, or several. Without it, the image that the graph writes.
    set
        Values of knobs and parameters: ``{"line_width": 1.5, "lines.softness": 2}``.
    frame
        For curves and sequences; without it the scene's.
    scale
        Above 0 up to 1: a smaller picture, with lengths to match.
    file
        An EXR to write the result to as well, encoded as the graph's write node says.
    name
        What the result is called, instead of the graph's name and the output's. It is filled again by later runs.

    Returns
    -------
    The datablock of the result, or a dict of them by output where several were asked for, or are written.

    Notes and warnings go to the logger "flowabs".

    Raises
    ------
    FlowabsError
        Whatever went wrong: :class:`~flowabs_nodes.graph.GraphError` for the graph, ``ReadError`` for the picture.
    """
    source, title = _graph(graph)
    picture = _picture(image, frame)
    names = main_outputs(load_graph(source)) if outputs is None else output_names(load_graph(source), outputs)
    chosen = PictureRun(
        graph=source,
        picture=picture,
        outputs=names,
        frame=bpy.context.scene.frame_current if frame is None else frame,
        scale=scale,
        values=set,
        file=None if file is None else Path(bpy.path.abspath(os.fspath(file))),
    )
    work = Background(chosen).start()
    work.wait()
    for level, text in work.notes:
        log.log(logging.WARNING if level == "warning" else logging.INFO, "%s", text)
    made_of = picture.name if isinstance(picture, Taken) else ""
    shown = {
        output: fill_datablock.show(
            made, _title(name or title, output, named=bool(name), several=len(names) > 1), made_of
        )
        for output, made in work.result().items()
    }
    one = isinstance(outputs, str) or (outputs is None and len(shown) == 1)
    return next(iter(shown.values())) if one else shown


def _title(stem: str, output: str, *, named: bool, several: bool) -> str:
    return stem if named and not several else f"{stem} {output}"


def _graph(graph: bpy.types.NodeTree | GraphSource) -> tuple[GraphSource, str]:
    """Return a graph as flowabs takes it, and its name."""
    tree = bpy.data.node_groups.get(graph) if isinstance(graph, str) else graph
    if isinstance(tree, bpy.types.NodeTree):
        if not is_ours(tree):
            raise CommandError(f"the node tree {tree.name!r} is no flowabs graph", code="wrong-type")
        return graph_of(tree), tree.name
    source = bpy.path.abspath(graph) if isinstance(graph, str) and graph.startswith("//") else graph
    loaded = load_graph(source)
    return loaded, Path(source).stem if isinstance(source, str | Path) else loaded.name or "flowabs"


def _picture(image: bpy.types.Image | str | os.PathLike[str], frame: int | None) -> Taken | Path:
    """Return what a graph is to run on."""
    datablock = bpy.data.images.get(image) if isinstance(image, str) else image
    if isinstance(datablock, bpy.types.Image):
        return take(datablock, frame=frame)
    path = Path(bpy.path.abspath(os.fspath(image)))
    if not path.exists():
        hint = nearest(str(image), [each.name for each in bpy.data.images]) if path.parent == Path() else ""
        raise CommandError(f"{image!r} is neither an image of this .blend nor a file", code="unknown-image", hint=hint)
    return path
