"""Describe a graph for a host's panel: knobs, pictures that go in, pictures that come out."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from typing import Any

from flowabs_nodes.choices import readable
from flowabs_nodes.engine.knob_states import knob_states
from flowabs_nodes.engine.plan import file_role, named_result, output_names, sinks
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.port_types import widest


def described(source: str, values: Mapping[str, Any], frame: int) -> dict[str, Any]:
    """Return a graph, by its name or path, as JSON: name, description, knobs, inputs, outputs, file, changed.

    Knobs stand where ``values`` set them, on a frame. Raises FlowabsError for a graph or values that are wrong.
    """
    loaded = load_graph(source)
    graph = loaded.with_set(values) if values else loaded
    changed = None
    with suppress(OSError):
        changed = os.stat(graph.source).st_mtime
    return {
        "name": graph.name,
        "description": graph.description,
        "knobs": [asdict(knob) for knob in knob_states(loaded, graph, frame)],
        "inputs": _inputs(graph),
        "outputs": _outputs(graph),
        "file": os.path.abspath(graph.source) if graph.source else None,
        "changed": changed,
    }


def _inputs(graph: Graph) -> list[dict[str, Any]]:
    """Return every picture that the graph reads, that of the first ``read``, the plate, before all others.

    Those are optional that the graph has a file for.
    """
    reads = [name for name in graph.document["nodes"] if name in graph.nodes and file_role(graph, name) == "input"]
    reads.sort(key=lambda name: graph.nodes[name].declaration.type != "read")
    used = {(link.node, link.output) for node in graph.nodes.values() for link in node.inputs.values()}
    found: list[dict[str, Any]] = []
    for name in reads:
        node = graph.nodes[name]
        ports, file = list(node.declaration.outputs), node.declaration.file_param
        found += (
            {
                "node": name,
                "output": port.name,
                "type": port.types,
                "optional": file is not None and file.name in node.params,
                "label": readable(name) if port is ports[0] else f"{readable(name)} {port.name}",
            }
            for port in [each for each in ports if (name, each.name) in used] or ports[:1]
        )
    return found


def _outputs(graph: Graph) -> list[dict[str, str]]:
    """Return what goes into write nodes; without such, the first output of each node that no other follows."""
    if sinks(graph):
        names = output_names(graph, None)
    else:
        followed = {link.node for node in graph.nodes.values() for link in node.inputs.values()}
        names = tuple(name for name, node in graph.nodes.items() if name not in followed)
    types = _types(graph)
    results = {name: named_result(graph, name, 1) for name in names}
    return [{"name": name, "type": types[result.node, result.output]} for name, result in results.items()]


def _types(graph: Graph) -> dict[tuple[str, str], str]:
    """Return the type of every output by node and output, followed through nodes that give what they are given."""
    types: dict[tuple[str, str], str] = {}
    for name, node in graph.nodes.items():  # each after the nodes whose results it needs
        for output, port in node.declaration.all_outputs.items():
            if not port.follows:
                types[name, output] = port.accepts[0]
                continue
            links = [node.inputs[each] for each in port.follows if each in node.inputs]
            inside = [types[link.node, link.output] for link in links]
            types[name, output] = widest(inside) or inside[0]
    return types
