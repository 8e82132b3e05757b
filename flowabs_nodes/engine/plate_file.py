"""Has nodes that read passes, and have no file of their own, read the file of the plate: a render with its passes."""

from __future__ import annotations

from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.overrides import override


def with_plate_file(graph: Graph) -> Graph:
    """Return the graph with the plate's file for every node that reads a picture and has no file.

    The plate is the graph's only ``read``, of several the one called "plate". Further ``read`` nodes have files of
    their own. Without a file of the plate, as where its picture is given, the graph stays as it is.
    """
    reads = [name for name, node in graph.nodes.items() if node.declaration.type == "read"]
    plate = reads[0] if len(reads) == 1 else "plate" if "plate" in reads else ""
    file = graph.document["nodes"].get(plate, {}).get("params", {}).get("file")
    if not file:
        return graph
    without = {
        f"{name}.{param.name}": file
        for name, node in graph.nodes.items()
        if (param := node.declaration.file_param) is not None
        and param.role == "input"
        and param.pictures
        and node.declaration.type != "read"
        and not node.params.get(param.name)
    }
    return override(graph, without) if without else graph
