"""Checks the graph of a tree, and puts what is wrong with it on the node concerned."""

from __future__ import annotations

import json
from typing import Any

import bpy

from flowabs_nodes.choices import readable
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph import GraphError, Problem, check

from . import knob_watch, tree_json
from .identifiers import MISSING, UNDEFINED, graph_nodes

#: What is said on a node in few words, by the problem's code; the rest is in the tooltip.
SHORT = {
    "missing-input": "{what} is not linked",
    "missing-param": "{what} is not set",
    "unknown-input": "it has no input {what}",
    "unknown-param": "it has no parameter {what}",
    "unknown-node": "{what}: there is no node {found}",
    "unknown-output": "{what}: there is no output {found}",
    "unknown-type": "not installed: {found}",
    "newer-version": "newer than what is installed: {found}",
    "unused-node": "nothing needs it",
    "unused-param": "{what} does nothing here",
    "cycle": "it needs its own result",
    "missing-package": "{found}",
}
USUAL = "{what}: {found}, expected {expected}"


def refresh(tree: bpy.types.NodeTree) -> list[Problem]:
    """Check a tree's graph, show what is wrong, and remember each node as it is; return the problems."""
    graph = tree_json.graph_of(tree)
    found = find(graph)
    nodes = {name: tree.nodes[key] for key, name in tree_json.names_of(tree).items()}
    of_node: dict[str, list[dict[str, Any]]] = {}
    elsewhere = []
    for problem in found:
        place = parts(problem.pointer)
        if place[:1] == ["nodes"] and len(place) > 1 and place[1] in nodes:
            of_node.setdefault(place[1], []).append(_shown(problem, place[2:]))
        else:
            elsewhere.append(_shown(problem, place))
    for name, node in nodes.items():
        if node.bl_idname == UNDEFINED:
            continue
        _set(node, "problems", json.dumps(of_node[name]) if name in of_node else "")
        if node.bl_idname != MISSING:
            body = graph["nodes"][name]
            _set(node, "snapshot", json.dumps(body))
    _set(tree, "problems", json.dumps(elsewhere) if elsewhere else "")
    _set(tree, "knob_positions", knob_watch.positions(tree))
    if len(tree.knobs) and all(problem.warning or problem.code == "missing-package" for problem in found):
        knob_watch.refresh(tree, graph)
    return found


def find(graph: dict[str, Any]) -> list[Problem]:
    """Return everything that is wrong with a graph; what stops the check itself is a problem of the whole."""
    try:
        return check(graph)
    except GraphError as error:
        return list(error.problems)
    except FlowabsError as error:
        return [Problem("bad-value", "", error.message, "a graph that can be checked", error.hint)]


def _set(owner: Any, name: str, text: str) -> None:
    """Set a property that has changed; Blender would store an equal one as a change too."""
    if getattr(owner, name) != text:
        setattr(owner, name, text)


def parts(pointer: str) -> list[str]:
    """Return the keys of a JSON Pointer."""
    return [part.replace("~1", "/").replace("~0", "~") for part in pointer.split("/")[1:]]


def _shown(problem: Problem, place: list[str]) -> dict[str, Any]:
    """Return a problem as panels show it: in few words, and all of it."""
    short = in_short(problem, place)
    return {"short": short, "long": problem.block, "warning": problem.warning, "place": place, "code": problem.code}


def in_short(problem: Problem, place: list[str]) -> str:
    """Return a problem in few words; ``place`` is where it is in its node, or in the graph."""
    what = readable(".".join(place[1:] or place)) or "Graph"
    return SHORT.get(problem.code, USUAL).format(what=what, found=problem.found, expected=problem.expected)


def mark_links(tree: bpy.types.NodeTree) -> None:
    """Draw the links red that lead between ports which do not fit; Blender itself marks those of a circle.

    Blender resets the marks after each change of a tree, after the tree's own ``update``.
    """
    wrong = {
        (node.name, problem["place"][1])
        for node in graph_nodes(tree)
        if node.bl_idname != UNDEFINED and node.problems
        for problem in json.loads(node.problems)
        if problem["code"] == "wrong-type" and problem["place"][:1] == ["inputs"] and len(problem["place"]) > 1
    }
    for link in tree.links if wrong else ():
        if (link.to_node.name, getattr(link.to_socket, "port", "")) in wrong:
            link.is_valid = False
