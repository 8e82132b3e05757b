"""Places nodes in the editor as a graph file's ``ui`` says, and says in ``ui`` where they were moved to.

Graph files have y down and nodes 220 apart; Blender's have y up, and are taller and wider. So a file's positions are
spread out on import, and those of nodes that were moved are drawn together again on export. What Blender remembers of a
node beyond its place (width, colour, collapsed, label) is in ``ui`` where it is not as a new node has it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import bpy

from .identifiers import graph_nodes
from .node_record import read_record
from .numbers import is_number

SPREAD_X, SPREAD_Y = 1.35, 2.4
COLUMN, ROW = 220, 160  # of nodes without a place, in a file's units

Look = dict[str, Any]


def place(nodes: Mapping[str, bpy.types.Node], ui: Mapping[str, Any], links: Mapping[str, list[str]]) -> None:
    """Place each node where ``ui`` has it, and the others below, in columns, each right of what it is linked to."""
    columns: dict[str, int] = {}
    filled: dict[int, int] = {}
    placed = {name: pos for name in nodes if (pos := _placed(ui.get(name))) is not None}
    first_row = max((y for _, y in placed.values()), default=-ROW) + ROW
    for name in _in_order(links):
        columns[name] = 1 + max((columns.get(source, -1) for source in links[name]), default=-1)
        if name not in placed:
            row = filled.get(columns[name], 0)
            filled[columns[name]] = row + 1
            placed[name] = (columns[name] * COLUMN, first_row + row * ROW)
        x, y = placed[name]
        nodes[name].location = (x * SPREAD_X, -y * SPREAD_Y)
        look = ui.get(name)
        if isinstance(look, dict):
            _dress(nodes[name], look)


def _placed(look: Any) -> tuple[float, float] | None:
    """Return the position that ``ui`` has of a node; None where it says none, or one that is no pair of numbers."""
    pos = look.get("pos") if isinstance(look, dict) else None
    fits = isinstance(pos, list) and len(pos) == 2 and all(map(is_number, pos))
    return (pos[0], pos[1]) if fits else None


def _in_order(links: Mapping[str, list[str]]) -> list[str]:
    """Return the names of nodes, each after those it is linked to as far as there is no cycle."""
    done: dict[str, None] = {}
    for start in links:
        stack = [(start, iter(links[start]))]
        entered = {start}
        while stack:
            name, sources = stack[-1]
            source = next((each for each in sources if each not in done and each not in entered), None)
            if source is None:
                done[name] = None
                stack.pop()
            else:
                entered.add(source)
                stack.append((source, iter(links[source])))
    return list(done)


def _dress(node: bpy.types.Node, look: Look) -> None:
    """Give a node the width, colour and label that ``ui`` says; what is no such value is passed over."""
    if is_number(look.get("width")):
        node.width = look["width"]
    if isinstance(look.get("label"), str):
        node.label = look["label"]
    if isinstance(look.get("collapsed"), bool):
        node.hide = look["collapsed"]
    color = look.get("color")
    if isinstance(color, list) and len(color) == 3 and all(map(is_number, color)):
        node.use_custom_color, node.color = True, color


def look_of(node: bpy.types.Node) -> Look:
    """Return how a node stands in the editor now, in the words of ``ui``, positions as the editor has them."""
    x, y = _location(node)
    return {
        "pos": [round(x, 3), round(y, 3)],
        "width": round(node.width, 2),
        "label": node.label,
        "collapsed": node.hide,
        "color": [round(part, 4) for part in node.color] if node.use_custom_color else None,
    }


def _location(node: bpy.types.Node) -> tuple[float, float]:
    """Return the place of a node's upper left corner, also of one in frames."""
    x, y = node.location
    while node.parent is not None:
        node = node.parent
        x, y = x + node.location[0], y + node.location[1]
    return x, y


def ui_of(
    tree: bpy.types.NodeTree, names: Mapping[str, str], recorded: Mapping[str, Any], former: Collection[str]
) -> dict[str, Any]:
    """Return the graph file's ``ui``: as ``recorded``, with what was renamed, moved, made and deleted since.

    ``names`` are the names of the graph's nodes, by the editor's; ``former`` those that the graph came in with.
    """
    nodes = {read_record(node).get("name", ""): node for node in graph_nodes(tree)}
    result: dict[str, Any] = {}
    for key, said in recorded.items():
        node = nodes.pop(key, None)
        if node is not None:
            result[names[node.name]] = _said_now(node, said)
        elif key not in former:
            result[key] = said
    for node in graph_nodes(tree):
        if names[node.name] not in result:
            said = _said_now(node, {})
            result.update({names[node.name]: said} if said else {})
    return result


def _said_now(node: bpy.types.Node, said: Any) -> Any:
    """Return what ``ui`` says of a node: what it said, with what has changed since import."""
    was = read_record(node).get("look", {})
    now = look_of(node)
    new = {"pos": None, "width": round(node.bl_width_default, 2), "label": "", "collapsed": False, "color": None}
    changed = {key: value for key, value in now.items() if value != was.get(key, new[key])}
    if not changed:
        return said
    if "pos" in changed:
        changed["pos"] = [round(now["pos"][0] / SPREAD_X), round(-now["pos"][1] / SPREAD_Y)]
    result = {**(said if isinstance(said, dict) else {}), **changed}
    return {key: value for key, value in result.items() if value is not None}
