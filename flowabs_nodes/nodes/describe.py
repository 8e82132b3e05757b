"""Makes a node's page from its declaration: plain text for the terminal, Markdown for the documentation."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable
from typing import Any

from flowabs_nodes.choices import CATEGORIES, readable
from flowabs_nodes.nodes.declare import Node, Param, Port

WIDTH = 100


def listing(nodes: Iterable[Node]) -> str:
    """Return one line for each node: its name and its help."""
    rows = [(node.name, node.help) for node in nodes]
    widest = max((len(name) for name, _ in rows), default=0)
    return "\n".join(f"{name:{widest}}  {help}" for name, help in rows)


def page(node: Node) -> str:
    """Return everything about a node, for the terminal."""
    lines = [f"{node.name}  {node.label}", "", *_wrapped(node.help, 2)]
    if node.doc:
        lines += ["", *_wrapped(node.doc, 2)]
    lines += ["", *_wrapped(facts(node), 2)]
    for title, ports in (("Inputs", inputs(node)), ("Outputs", outputs(node))):
        if ports:
            name_width = max(len(name) for name, _, _ in ports)
            type_width = max(len(types) for _, types, _ in ports)
            lines += ["", title]
            for name, types, help in ports:
                lines += _wrapped(help, name_width + type_width + 6, f"  {name:{name_width}}  {types:{type_width}}  ")
    for section, params in node.sections().items():
        lines += ["", f"Parameters: {section}" if section else "Parameters"]
        for param in params:
            lines += _wrapped(f"{param.name}: {rule(param)}; {default(param)}", 6, "  ")
            lines += _wrapped(f"{param.label}: {param.help}", 6)
            for note in (*conditions(param), *choices(param)):
                lines += _wrapped(note, 8, "      ")
    return "\n".join(lines)


def reference(nodes: Iterable[Node]) -> str:
    """Return the pages of all nodes, as Markdown."""
    nodes = tuple(nodes)
    rows = (
        f"| [`{node.name}`](#{node.type}{node.version}) | {_cell(node.label)} | {_cell(node.category)} "
        f"| {_cell(node.help)} |"
        for node in nodes
    )
    lines = ["| node | label | category | |", "|---|---|---|---|", *rows]
    return "\n".join([*lines, *(line for node in nodes for line in ("", *_markdown(node)))])


def _markdown(node: Node) -> list[str]:
    lines = [f"## {node.name}", "", f"**{node.label}.** {node.help}"]
    if node.doc:
        lines += ["", node.doc]
    lines += ["", facts(node)]
    ports = [("in", *row) for row in inputs(node)] + [("out", *row) for row in outputs(node)]
    if ports:
        lines += ["", "| | port | type | |", "|---|---|---|---|"]
        lines += [f"| {way} | `{name}` | {_cell(types)} | {_cell(help)} |" for way, name, types, help in ports]
    if node.all_params:
        lines += ["", "| parameter | label | default | value | |", "|---|---|---|---|---|"]
        for section, params in node.sections().items():
            lines += [f"| **{section}** | | | | |"] if section else []
            lines += [_markdown_row(param) for param in params]
    return lines


def _markdown_row(param: Param) -> str:
    word, space, value = default(param).partition("default ")
    shown = f"`{value}`" if space else word
    help = "<br>".join((" ".join((param.help, *conditions(param))), *choices(param)))
    return f"| `{param.name}` | {_cell(param.label)} | {_cell(shown)} | {_cell(rule(param))} | {_cell(help)} |"


def inputs(node: Node) -> list[tuple[str, str, str]]:
    """Return name, type and help of each input."""
    ports = node.all_inputs.values()
    rows = [(port.name, _types(port) + _optional(node, port), port.help) for port in ports]
    if node.extra_inputs:
        rows.append(("(any name)", f"{_types(node.extra_inputs)}, optional", node.extra_inputs.help))
    return rows


def _optional(node: Node, port: Port) -> str:
    """Return what to say behind the types of an input that need not be connected."""
    if port.name in node.one_of:
        return f", one of {', '.join(node.one_of)} is needed"
    beside = f", with {port.beside}" if port.beside else ""
    return f", optional{beside}" if port.optional else ""


def outputs(node: Node) -> list[tuple[str, str, str]]:
    """Return name, type and help of each output; a link that names no output means the first."""
    rows = [(port.name, _types(port), port.help) for port in node.outputs]
    if len(rows) > 1:
        rows[0] = (rows[0][0], f"{rows[0][1]}, default", rows[0][2])
    return rows


def _types(port: Port) -> str:
    if len(port.follows) > 2:
        return f"as {port.follows[0]} to {port.follows[-1]}, the widest"
    if port.follows:
        return "as " + ", or ".join(port.follows) + ", the wider" * (len(port.follows) > 1)
    return "any" if port.types == "any" else port.types.replace("|", " or ")


def facts(node: Node) -> str:
    """Say where a menu lists the node, what it reads beside the pixels of its own window and frame, and needs."""
    said = [f"In menus under {CATEGORIES.label.get(node.category, node.category)}."]
    if node.inputs and node.outputs:
        part = "It can work on a part of the picture" if node.region else "It needs the whole picture"
        said.append(f"{part}{', and reads other frames' if node.frames else ''}.")
    said += [f"It needs {module}: pip install '{source}'." for module, source in node.packages.items()]
    return " ".join(said)


def conditions(param: Param) -> list[str]:
    """Say beside which values of others the parameter does something, and whether a number takes no curve."""
    said = [f"Ignored unless {name} is {' or '.join(map(_json, each))}." for name, each in param.enabled_when.items()]
    return said + (["The same on every frame."] if param.numeric and not param.animatable else [])


def choices(param: Param) -> list[str]:
    """Say what each choice does, and its label if that is another word; nothing where no meaning is known."""
    labels = {word: label for word, label in param.choice_labels.items() if label != readable(word)}
    return [
        f"{word} ({labels[word]}): {meaning}" if word in labels else f"{word}: {meaning}"
        for word, meaning in param.choice_meanings.items()
    ]


def rule(param: Param) -> str:
    """Say what a value has to be, with the usual range: "a number from 0 to 100 (px), usually 2 to 15"."""
    usual = f", usually {param.soft[0]:g} to {param.soft[1]:g}" if param.soft else ""
    return param.expected + usual


def default(param: Param) -> str:
    """Say the default as a graph would write it; of a required parameter, that it is required."""
    if param.kind == "file":
        return "set by the graph or the run"
    return "required" if param.required else f"default {_json(param.default)}"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def _wrapped(text: str, indent: int, first: str | None = None) -> list[str]:
    initial = " " * indent if first is None else first
    lines = textwrap.wrap(text, WIDTH, initial_indent=initial, subsequent_indent=" " * indent, break_on_hyphens=False)
    return lines or [initial.rstrip()]


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
