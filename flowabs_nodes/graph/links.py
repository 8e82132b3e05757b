"""Checks the links of a graph: where each input comes from, whether the ports fit, cycles, and unused nodes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes.graph import order
from flowabs_nodes.graph.format import NAME, NAME_RULE
from flowabs_nodes.graph.model import Link
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.nodes.declare import Node, Port
from flowabs_nodes.port_types import widest

#: Each node's declaration, by the node's name; None where its type is not known (nothing more is said about it).
Declarations = Mapping[str, Node | None]
Links = Mapping[str, Mapping[str, Link]]


def read_links(
    name: str, raw: dict[str, Any], declarations: Declarations, place: Place, problems: Problems
) -> dict[str, Link]:
    """Return the links of one node that lead somewhere, by input; what is wrong with the others becomes a problem."""
    declaration = declarations[name]
    ports = list(raw) if declaration is None else _known_inputs(declaration, raw, place, problems)
    links = {port: _read_link(raw[port], declarations, (*place, port), problems) for port in ports}
    return {port: link for port, link in links.items() if link is not None}


def _known_inputs(declaration: Node, raw: dict[str, Any], place: Place, problems: Problems) -> list[str]:
    """Return the keys of ``raw`` that are inputs of the node.

    A wrong name stands for the input it is closest to, which is then not reported as missing: one mistake.
    """
    known = []
    open_ports = [port for port in declaration.all_inputs if port not in raw]
    for port in raw:
        if declaration.input(port) is None:
            meant, hint = problems.meant(port, open_ports, declaration.all_inputs)
            problems.add("unknown-input", (*place, port), show(port), f"an input of {declaration.name}", hint)
            if meant:
                open_ports.remove(meant)
        elif not NAME.fullmatch(port):
            problems.add("bad-value", (*place, port), f"the name {show(port)}", f"a layer's name: {NAME_RULE}")
        elif port not in declaration.all_inputs and port in taken_names(declaration):
            expected = f"a layer's name other than those of {declaration.type}'s parameters"
            problems.add("bad-value", (*place, port), f"the name {show(port)}", expected)
        else:
            known.append(port)
    for port in open_ports:
        if not declaration.all_inputs[port].optional:
            expected = f"a link to a node that gives {types_in_words(declaration.all_inputs[port])}"
            problems.add("missing-input", (*place, port), "nothing", expected)
    for port in known:
        beside = declaration.all_inputs[port].beside if port in declaration.all_inputs else ""
        if beside and beside not in known:
            problems.add("missing-input", (*place, beside), "nothing", f"a link, as {port} has one")
    if declaration.one_of and not any(port in known for port in declaration.one_of):
        names = ", ".join(declaration.one_of)
        problems.add("missing-input", (*place, declaration.one_of[0]), "nothing", f"a link to at least one of {names}")
    return known


def taken_names(declaration: Node) -> list[str]:
    """Return the names that an extra input cannot have, because the node's function gets other things by them."""
    return ["context", *declaration.all_params]


def _read_link(raw: Any, declarations: Declarations, place: Place, problems: Problems) -> Link | None:
    if not isinstance(raw, str):
        problems.add("wrong-type", place, show(raw), 'a link: "node" or "node.output"')
        return None
    node, dot, output = raw.partition(".")
    if node not in declarations:
        hint = problems.near(node, declarations)
        problems.add("unknown-node", place, show(node), "a node of this graph", hint)
        return None
    declaration = declarations[node]
    if declaration is None:
        return Link(node, output)
    outputs = declaration.all_outputs
    if not outputs:
        problems.add("unknown-output", place, show(raw), f"a node that has an output; {declaration.name} has none")
        return None
    if dot and output not in outputs:
        hint = problems.near(output, outputs)
        problems.add("unknown-output", place, show(raw), f"an output of {node}, which is {declaration.name}", hint)
        return None
    return Link(node, output if dot else next(iter(outputs)))


def check_links(declarations: Declarations, links: Links, problems: Problems) -> list[str]:
    """Find cycles and ports that do not fit. Return the names of the nodes, each after the nodes it needs."""
    needs = {name: [link.node for link in links.get(name, {}).values()] for name in declarations}
    names: list[str] = []
    for component in order.components(needs):
        names.extend(component)
        if len(component) > 1 or component[0] in needs[component[0]]:
            _add_cycle(order.cycle(component, needs), links, problems)
    _check_types(names, declarations, links, problems)
    return names


def _add_cycle(cycle: list[str], links: Links, problems: Problems) -> None:
    node, source = cycle[1], cycle[0]
    port = next(port for port, link in links[node].items() if link.node == source)
    path = [*cycle[:8], "...", cycle[-1]] if len(cycle) > 9 else cycle
    expected = "no node that needs its own result"
    problems.add("cycle", ("nodes", node, "inputs", port), " -> ".join(path), expected, "take one of these links away")


def _check_types(names: list[str], declarations: Declarations, links: Links, problems: Problems) -> None:
    """Follow the port types through the graph. A type that another mistake hides makes no problem."""
    gives: dict[Link, str | None] = {}
    for name in names:
        declaration = declarations[name]
        if declaration is None:
            continue
        inside: dict[str, str | None] = {}
        for input_name, link in links.get(name, {}).items():
            given, port = gives.get(link), declaration.input(input_name)
            if given is None or port is None:
                continue
            inside[input_name] = port.takes(given)
            if inside[input_name] is None:
                other = next(
                    (o for o, type in gives.items() if o.node == link.node and type and port.takes(type)), None
                )
                hint = f"did you mean {str(other)!r}?" if other else ""
                place = ("nodes", name, "inputs", input_name)
                problems.add("wrong-type", place, f"{link}, which is {given}", types_in_words(port), hint)
        for output, port in declaration.all_outputs.items():
            own = port.accepts[0] if port.accepts else None
            gives[Link(name, output)] = _common_type(name, port, inside, links[name], problems) if port.follows else own


def _common_type(
    name: str, output: Port, inside: Mapping[str, str | None], links: Mapping[str, Link], problems: Problems
) -> str | None:
    """Return the type of an output that has the type of its inputs, which are to fit each other; None if unknown."""
    types: dict[str, str] = {}
    for port in output.follows:
        kind = inside.get(port)
        if kind is None:
            if port in links:
                return None
            continue
        if types and widest((*types.values(), kind)) is None:
            first, other = next(iter(types.items()))
            expected = f"the same type as the input {first}, {other}, or one that goes where that goes"
            problems.add("wrong-type", ("nodes", name, "inputs", port), f"{links[port]}, which is {kind}", expected)
            return None
        types[port] = kind
    return widest(types.values())


def add_unused(names: list[str], declarations: Declarations, links: Links, problems: Problems) -> None:
    """Warn of each node that no ``write`` needs, in a graph that has one."""
    for name in unused(names, declarations, links):
        expected = f"a link from it that leads to {' or '.join(_writes(declarations)[:4])}"
        problems.add("unused-node", ("nodes", name), f"{name}, which nothing needs", expected, warning=True)


def unused(names: list[str], declarations: Declarations, links: Links) -> list[str]:
    """Return the nodes that no ``write`` needs, in a graph that has one; ``names`` has each after those it needs."""
    writes = _writes(declarations)
    needed = set(writes)
    for name in reversed(names):
        if name in needed:
            needed.update(link.node for link in links.get(name, {}).values())
    return [name for name in declarations if writes and name not in needed]


def _writes(declarations: Declarations) -> list[str]:
    files = {name: node.file_param for name, node in declarations.items() if node}
    return [name for name, file in files.items() if file and file.role == "output"]


def types_in_words(port: Port) -> str:
    """Say what a port takes: "color", "color or mono"."""
    return "any image" if port.types == "any" else port.types.replace("|", " or ")
