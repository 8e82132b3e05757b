"""Makes a graph file's document of a node tree, and a node tree of a document: the contract of all that runs a graph.

``graph_of(tree)`` is what the tree says now, plain data for ``flowabs_nodes.load_graph``; ``fill(tree, graph)`` makes
the tree say what the graph says. What was not touched in between comes out as it came in, to the last digit and in the
same order, also where it is wrong or of a package that is not installed.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Mapping
from typing import Any

import bpy

from flowabs_nodes.graph.format import FORMAT
from flowabs_nodes.graph.jsonable import jsonable
from flowabs_nodes.graph.problems import GraphError, Problems, show
from flowabs_nodes.graph.upgrade import upgrade_format, upgrade_node
from flowabs_nodes.nodes import catalogue

from . import knobs, layout, node_body
from .identifiers import graph_nodes
from .links import link_nodes, wiring
from .names import clean, unique
from .node_record import read_record, stored


def graph_of(tree: bpy.types.NodeTree) -> dict[str, Any]:
    """Return the graph that a tree stands for, as a graph file has it."""
    record = json.loads(tree.record) if tree.record else {"head": {"format": FORMAT}}
    document = copy.deepcopy(record["head"])
    if tree.name != record.get("shown_name"):
        document = {**document, "name": tree.name}
    interface = knobs.interface_of(tree)
    if interface or isinstance(document.get("interface"), dict):
        document = _with(document, "interface", interface, before="nodes")
    names = names_of(tree)
    nodes = {tree_node.name: tree_node for tree_node in graph_nodes(tree)}
    wires = wiring(tree)
    document["nodes"] = {name: node_body.body_of(nodes[key], names, wires) for key, name in names.items()}
    recorded = document.get("ui")
    ui = layout.ui_of(tree, names, recorded if isinstance(recorded, dict) else {}, record.get("names", []))
    if ui or isinstance(recorded, dict):
        document["ui"] = ui
    return document


def _with(document: dict[str, Any], key: str, value: Any, before: str) -> dict[str, Any]:
    """Return the document with a key, which stands before another if it is new."""
    if key in document or before not in document:
        return {**document, key: value}
    result = {}
    for each, said in document.items():
        result.update({key: value} if each == before else {})
        result[each] = said
    return result


def names_of(tree: bpy.types.NodeTree) -> dict[str, str]:
    """Return the graph's name of each of its nodes by the editor's, in the order of the file; each name once."""
    places = {node.name: read_record(node).get("place", 10**9) for node in graph_nodes(tree)}
    found: dict[str, str] = {}
    taken: set[str] = set()
    for node in sorted(graph_nodes(tree), key=lambda node: places[node.name]):
        name = unique(stored(node, "graph_name") or clean(node.name), taken)
        found[node.name] = name
        taken.add(name)
    return found


def fill(tree: bpy.types.NodeTree, graph: Mapping[str, Any]) -> list[str]:
    """Make a tree hold a graph, in place of all that it has.

    Returns what was done to bring older nodes up to date, in sentences. Raises GraphError, and leaves the tree as it
    is, where the graph is of a newer format, or no graph at all. All other mistakes of a graph are kept, and shown.
    """
    document, notes = readable(graph)
    tree.is_filling = True
    try:
        clear(tree)
        ui = document.get("ui") if isinstance(document.get("ui"), dict) else {}
        head = {**document, "nodes": {}}
        knobs.fill(tree, document.get("interface"))
        if isinstance(document.get("interface"), dict):
            head["interface"] = {}
        bodies = document["nodes"]
        nodes = {
            name: node_body.make_node(tree, name, body, number) for number, (name, body) in enumerate(bodies.items())
        }
        sources = link_nodes(tree, nodes, bodies)
        layout.place(nodes, ui, sources)
        for node in nodes.values():
            node_body.remember(node)
        if isinstance(document.get("name"), str) and document["name"]:
            tree.name = document["name"]
        tree.record = json.dumps({"head": head, "names": list(nodes), "shown_name": tree.name})
        tree.use_fake_user = True
    finally:
        tree.is_filling = False
    tree.update()
    return notes


def readable(graph: Mapping[str, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return a graph as a document of this version's format, and what was done to bring it up to date."""
    found, notes = Problems(), []
    document = jsonable(graph, found)
    if not isinstance(document, dict):
        found.add("wrong-type", (), show(document), "an object with format and nodes")
    if found.found:
        raise GraphError(found.found)
    upgraded = upgrade_format(document, found, notes)
    if upgraded is None:
        raise GraphError(found.found)
    if not isinstance(upgraded.get("nodes"), dict):
        found.add("wrong-type", ("nodes",), show(upgraded.get("nodes")), "an object")
        raise GraphError(found.found)
    if found.found:  # no known format: kept as it is, and shown
        del upgraded["format"]
        upgraded = document if "format" in document else upgraded
    for name, body in upgraded["nodes"].items():
        if isinstance(body, dict) and isinstance(body.get("type"), str):
            upgrade_node(body, ("nodes", name), catalogue(), Problems(), notes)
    return upgraded, notes


def clear(tree: bpy.types.NodeTree) -> None:
    """Take everything of a graph out of a tree."""
    tree.nodes.clear()
    knobs.fill(tree, {})
    tree.animation_data_clear()
    tree.record = tree.problems = ""
