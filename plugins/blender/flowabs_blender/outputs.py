"""Says which outputs of a graph are its results, and which node writes them."""

from __future__ import annotations

from typing import Any

from flowabs_nodes import RunnableGraph, load_graph
from flowabs_nodes.engine.plan import Result, named_result, output_names, sinks
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.nodes import catalogue

from .names import unique


def main_outputs(graph: Graph) -> tuple[str, ...]:
    """Return the outputs that are the image of a write node, by name; further layers are none of them.

    Raises CommandError where the graph writes nothing.
    """
    written = {named_result(graph, name, 1): name for name in output_names(graph, None)}
    found = [image_of(graph, sink) for sink in sinks(graph)]
    return tuple(dict.fromkeys(written[result] for result in found if result is not None))


def writer_of(graph: Graph, output: str) -> str | None:
    """Return the node that writes an output as its image; None where none does."""
    result = named_result(graph, output, 1)
    return next((sink for sink in sinks(graph) if image_of(graph, sink) == result), None)


def image_of(graph: Graph, sink: str) -> Result | None:
    """Return the result that a write node gets as its image."""
    link = graph.nodes[sink].inputs.get("image")
    return None if link is None else Result(link.node, link.output, 1)


def writing_only(graph: RunnableGraph, output: str) -> RunnableGraph:
    """Return the graph that writes one output alone: by the write node that gets it as its image, else by a new one.

    Raises CommandError for a name that is no output of the graph.
    """
    result, kept = named_result(graph, output, 1), writer_of(graph, output)
    nodes = {name: body for name, body in graph.document["nodes"].items() if name == kept or name not in sinks(graph)}
    if kept is None:
        body: dict[str, Any] = {
            "type": catalogue()["write"].name,
            "inputs": {"image": f"{result.node}.{result.output}"},
        }
        nodes[unique("out", nodes)] = body
    return load_graph({**graph.document, "nodes": nodes})
