"""Says which node of a graph a picture stands for, and gives it to the graph."""

from __future__ import annotations

from pathlib import Path

from flowabs_nodes import Image, RunnableGraph
from flowabs_nodes.engine.plan import file_role
from flowabs_nodes.errors import CommandError
from flowabs_nodes.graph.model import Graph

from .taken import Taken


def plate_of(graph: Graph) -> str:
    """Return the ``read`` node that a picture stands for: one without a file, of several the one called "plate".

    Where each has a file: of all of them the one called "plate", else the first. Raises CommandError where the graph
    has no ``read``.
    """
    reads = [name for name in graph.document["nodes"] if graph.nodes[name].declaration.type == "read"]
    if not reads:
        raise CommandError("the graph reads no picture: it has no read node", code="no-read")
    candidates = [name for name in reads if not _file(graph, name)] or reads
    return "plate" if "plate" in candidates else candidates[0]


def with_picture(
    graph: RunnableGraph, picture: Image | Taken | Path, passes: Path | None = None
) -> tuple[RunnableGraph, dict[str, Image]]:
    """Return the graph that works on a picture, and what it is to be given under which names.

    Further nodes that read, and have no file of their own, read the picture's file: passes of the same render. Of an
    Image ``passes`` names that file.

    Raises
    ------
    CommandError
        The graph reads no picture.
    ReadError, ColorError
        As :meth:`Taken.image`.
    """
    plate = plate_of(graph)
    if isinstance(picture, Path):
        return graph.with_set({f"{plate}.file": str(picture), **_further(graph, plate, picture)}), {}
    if isinstance(picture, Taken):
        picture, passes = picture.image(layer_of(graph, plate)), picture.file
    further = _further(graph, plate, passes) if passes is not None else {}
    return (graph.with_set(further) if further else graph), {plate: picture}


def layer_of(graph: Graph, plate: str) -> str:
    """Return the layer of a file that the plate's node reads; "" is its picture."""
    return str(graph.values(1)[plate]["layer"])


def _further(graph: Graph, plate: str, file: Path) -> dict[str, str]:
    """Return the file for each node that reads one and has none, but for the plate's."""
    reads = (name for name in graph.nodes if file_role(graph, name) == "input" and name != plate)
    return {f"{name}.{_param(graph, name)}": str(file) for name in reads if not _file(graph, name)}


def _file(graph: Graph, name: str) -> str:
    return str(graph.values(1)[name].get(_param(graph, name)) or "")


def _param(graph: Graph, name: str) -> str:
    param = graph.nodes[name].declaration.file_param
    assert param is not None
    return param.name
