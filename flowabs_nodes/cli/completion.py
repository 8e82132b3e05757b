"""Says what may be typed next on a command line, for the shell's Tab: graphs, files, knobs, values, nodes."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.shell_completion import CompletionItem

from flowabs_nodes.errors import FlowabsError

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph
    from flowabs_nodes.nodes.declare import Param

Items = list[CompletionItem[str]]
Complete = Callable[[click.Context, click.Parameter, str], Items]


def shipped_graphs(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the names of the graphs that come with flowabs, the paper's figures last."""
    from flowabs_nodes.graph.shipped import paper, shipped

    return _matching(incomplete, {name: _description(path) for name, path in (shipped() | paper()).items()})


def graphs(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return what may stand for GRAPH: a shipped graph, a file that ends in .json, or a folder on the way to one.

    Where there are only folders, the shell completes them itself, which then puts no space behind their names.
    """
    shipped = shipped_graphs(context, parameter, incomplete)
    files, folders = _json_files(incomplete)
    if not shipped and not files:
        return [CompletionItem(incomplete, type="file")]
    return [*shipped, *map(CompletionItem, files), *map(CompletionItem, folders)]


def nodes(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the types of the nodes that are installed."""
    from flowabs_nodes.nodes import catalogue

    return _matching(incomplete, {node.type: node.help for node in catalogue().values()})


def settings(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return what may follow --set: knobs and nodes of the GRAPH on the line, a node's parameters, or values of one."""
    graph = _graph_on_the_line(context)
    if graph is None:
        return []
    name, equals, _ = incomplete.partition("=")
    node, dot, _ = name.partition(".")
    params = graph.nodes[node].declaration.all_params if dot and node in graph.nodes else {}
    choices: dict[str, str]
    if equals:
        knob = graph.interface.get(name)
        what = knob.param if knob else params.get(name[len(node) + 1 :])
        choices = {f"{name}={value}": help for value, help in _values(what).items()} if what else {}
    elif dot:
        choices = {f"{node}.{each.name}=": each.help for each in params.values()}
    else:
        choices = {f"{knob.name}=": knob.help for knob in graph.interface.values()}
        choices |= {f"{each.name}.": each.declaration.help for each in graph.nodes.values()}
    return _matching(incomplete, choices)


def graph_nodes(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Return the outputs of the GRAPH on the line, each as its node's name or as node.output."""
    graph = _graph_on_the_line(context)
    named: dict[str, str] = {}
    for node in graph.nodes.values() if graph else ():
        outputs = node.declaration.all_outputs
        names = [node.name, *(f"{node.name}.{output}" for output in list(outputs)[1:])]
        named |= dict(zip(names, (port.help for port in outputs.values()), strict=False))
    return _matching(incomplete, named)


def files(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Let the shell complete a file."""
    return [CompletionItem(incomplete, type="file")]


def folders(context: click.Context, parameter: click.Parameter, incomplete: str) -> Items:
    """Let the shell complete a folder."""
    return [CompletionItem(incomplete, type="dir")]


#: What completes an option's value, by the first word of what stands for it in the help.
_BY_METAVAR: Mapping[str, Complete] = {
    "FILE": files,
    "CONFIG": files,
    "DIR": folders,
    "NAME=VALUE": settings,
    "NODE": graph_nodes,
}


def of_option(metavar: str | None) -> Complete | None:
    """Return what completes the value of an option with this metavar; None leaves it to the option's type."""
    return _BY_METAVAR.get((metavar or "").partition("[")[0])


def _graph_on_the_line(context: click.Context) -> Graph | None:
    """Return the graph that the line names; None where it names none, or one that cannot be loaded."""
    from flowabs_nodes import graph as graphs

    # While an option waits for its value, click has not given the words that are left to GRAPH yet.
    named = context.params.get("graph") or next(iter(context.args), None)
    try:
        return graphs.load(named) if named else None
    except FlowabsError:
        return None


def _values(param: Param) -> dict[str, str]:
    """Return values that a parameter may be set to: all of a short list, of a number its default."""
    match param.kind:
        case "enum":
            return {word: param.choice_meanings.get(word, "") for word in param.choices}
        case "bool":
            return {"true": "", "false": ""}
        case "float" | "int" if param.default is not None:
            return {json.dumps(param.default): f"{param.expected}; this is the default"}
    return {}


def _json_files(incomplete: str) -> tuple[list[str], list[str]]:
    """Return the files that end in .json and the folders (with a slash) whose path begins with ``incomplete``."""
    head, tail = os.path.split(incomplete)
    prefix = incomplete[: len(incomplete) - len(tail)]
    try:
        entries = sorted(os.scandir(os.path.expanduser(head) or "."), key=lambda entry: entry.name)
        found = [entry for entry in entries if entry.name.startswith(tail) and (tail or entry.name[0] != ".")]
        files = [prefix + entry.name for entry in found if entry.name.endswith(".json") and entry.is_file()]
        return files, [f"{prefix}{entry.name}/" for entry in found if entry.is_dir()]
    except OSError:
        return [], []


def _description(path: Path) -> str:
    """Return what a shipped graph says of itself."""
    said: str = json.loads(path.read_text(encoding="utf-8"))["description"]
    return said


def _matching(incomplete: str, named: Mapping[str, str]) -> Items:
    """Return an item for each name that begins with ``incomplete``, with its help where there is one."""
    return [CompletionItem(name, help=help or None) for name, help in named.items() if name.startswith(incomplete)]
