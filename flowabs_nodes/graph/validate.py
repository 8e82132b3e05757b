"""Makes a graph of a document: every problem in one go, each mistake reported once.

What follows from a mistake is not reported again: a node of unknown type has neither unknown parameters nor wrong
links, a link that leads nowhere is not a missing input, and a broken knob drives anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes.graph import document_keys
from flowabs_nodes.graph.chosen_inputs import add_unlinked_choices
from flowabs_nodes.graph.format import MOST_NODES
from flowabs_nodes.graph.knobs import read_knobs
from flowabs_nodes.graph.links import add_unused, check_links, read_links, unused
from flowabs_nodes.graph.model import Graph, GraphNode, Knob, Link
from flowabs_nodes.graph.parameters import read_value
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.graph.reference_size import read_reference_size
from flowabs_nodes.graph.unused_params import add_unused_knobs, add_unused_params
from flowabs_nodes.graph.upgrade import upgrade_format, upgrade_node
from flowabs_nodes.graph.values import Value
from flowabs_nodes.nodes.declare import Node


def validate(document: Any, catalogue: Mapping[str, Node], problems: Problems, source: str = "") -> Graph | None:
    """Return the graph, or None if there is any error. The document is plain data, and brought up to date in place."""
    if not isinstance(document, dict):
        problems.add("wrong-type", (), show(document), "an object with format and nodes")
        return None
    notes: list[str] = []
    upgraded = upgrade_format(document, problems, notes)
    if upgraded is None:
        return None
    top = document_keys.read_fields(upgraded, (), document_keys.GRAPH, problems, required=("nodes",))
    reference_size = read_reference_size(top, problems)
    knobs = read_knobs(top.get("interface", {}), problems)
    raw_nodes = top.get("nodes", {})
    if len(raw_nodes) > MOST_NODES:
        problems.add("too-big", ("nodes",), f"{len(raw_nodes)} nodes", f"at most {MOST_NODES}")
        return None
    nodes = _read_nodes(raw_nodes, catalogue, knobs, problems, notes)
    interface = {name: knob for name, knob in knobs.items() if knob is not None}
    if not problems.errors:  # else what is chosen may be what a mistake hides
        add_unlinked_choices((nodes[name] for name in raw_nodes), interface, problems)
    if problems.errors:
        return None
    add_unused_params((nodes[name] for name in raw_nodes), interface, problems)
    declarations = {name: node.declaration for name, node in nodes.items()}
    idle = unused(list(nodes), declarations, {name: node.inputs for name, node in nodes.items()})
    add_unused_knobs(nodes.values(), interface, idle, problems)
    return Graph(
        name=top.get("name", ""),
        description=top.get("description", ""),
        reference_size=reference_size,
        interface=interface,
        nodes=nodes,
        ui=top.get("ui", {}),
        document=upgraded,
        source=source,
        notes=tuple(notes),
        warnings=tuple(problem for problem in problems.found if problem.warning),
    )


def _read_nodes(
    raw_nodes: dict[str, Any],
    catalogue: Mapping[str, Node],
    knobs: Mapping[str, Knob | None],
    problems: Problems,
    notes: list[str],
) -> dict[str, GraphNode]:
    place: Place = ("nodes",)
    bodies: dict[str, dict[str, Any]] = {}
    declarations: dict[str, Node | None] = {}
    for name, raw in document_keys.read_named(raw_nodes, place, "a node's name", problems).items():
        body = document_keys.read_fields(raw, (*place, name), document_keys.NODE, problems, required=("type",))
        written = body.get("type")
        declarations[name] = (
            upgrade_node(body, (*place, name), catalogue, problems, notes) if written is not None else None
        )
        if body.get("type") != written:
            raw.update(body)  # the document shows what was read
        bodies[name] = body
    params: dict[str, dict[str, Value]] = {}
    links: dict[str, dict[str, Link]] = {}
    unlinked = False
    for name, body in bodies.items():
        here = (*place, name)
        declaration = declarations[name]
        if declaration is not None:
            params[name] = _read_params(name, declaration, body.get("params", {}), knobs, (*here, "params"), problems)
        before = problems.errors
        links[name] = read_links(name, body.get("inputs", {}), declarations, (*here, "inputs"), problems)
        unlinked |= declaration is None or problems.errors > before
    order = check_links(declarations, links, problems)
    if not unlinked:  # else what seems to be needed by nothing may be what a broken link meant
        add_unused(order, declarations, links, problems)
    nodes = {name: declarations[name] for name in order}
    return {name: GraphNode(name, node, links[name], params[name]) for name, node in nodes.items() if node is not None}


def _read_params(
    node: str,
    declaration: Node,
    raw: dict[str, Any],
    knobs: Mapping[str, Knob | None],
    place: Place,
    problems: Problems,
) -> dict[str, Value]:
    """Return the values of the parameters that are set.

    An unknown name stands for the parameter it is closest to, which is then not reported as missing: one mistake.
    """
    declared = declaration.all_params
    values: dict[str, Value] = {}
    # A file may also be set when the graph is run.
    missing = [name for name, param in declared.items() if param.required and param.kind != "file" and name not in raw]
    for name, item in raw.items():
        if name in declared:
            value = read_value(declared[name], item, knobs, f"{node}.{name}", (*place, name), problems)
            if value is not None:
                values[name] = value
        else:
            meant, hint = problems.meant(name, [other for other in declared if other not in raw], declared)
            problems.add("unknown-param", (*place, name), show(name), f"a parameter of {declaration.name}", hint)
            missing = [other for other in missing if other != meant]
    for name in missing:
        problems.add("missing-param", (*place, name), "nothing", declared[name].expected)
    return values
