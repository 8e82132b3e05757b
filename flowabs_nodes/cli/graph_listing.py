"""``flowabs graphs``: lists the graphs that come with flowabs and their knobs, or prints the file of one."""

from __future__ import annotations

import json
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.errors import CommandError, nearest

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Graph, Knob


@click.command()
@click.argument("name", required=False, shell_complete=completion.shipped_graphs)
@click.option("--json", "as_json", is_flag=True, help="One JSON document: name, file, description and knobs of each.")
def graphs(name: str | None, as_json: bool) -> None:
    """The graphs that come with flowabs, and the knobs of each (set one with --set knob=value).

    With a NAME, that graph's file, to be changed and run: flowabs graphs lines > my.json
    """
    from flowabs_nodes.graph.shipped import paper, shipped

    known = shipped() | paper()
    if name is not None and name not in known:
        raise CommandError(
            f"no graph named {name!r} comes with flowabs", code="unknown-graph", hint=nearest(name, known)
        )
    if as_json:
        entries = [_data(each, known[each]) for each in ([name] if name else known)]
        click.echo(json.dumps(entries[0] if name else entries, indent=2, ensure_ascii=False))
    elif name is not None:
        _print_file(name, known[name])
    else:
        _list(shipped(), paper())


def _print_file(name: str, path: Path) -> None:
    """Print a graph's file on stdout as it is; on a terminal also say on stderr what to do with it."""
    if sys.stdout.isatty():
        click.echo(f"# to change it: flowabs graphs {name} > my.json, then flowabs run ./my.json", err=True)
    click.echo(path.read_text(encoding="utf-8"), nl=False)


def _list(shipped: dict[str, Path], paper: dict[str, Path]) -> None:
    """Print the graphs with their knobs, and a line for each figure of the paper."""
    for name, path in shipped.items():
        graph = _load(path)
        click.echo(name)
        click.echo(textwrap.fill(graph.description, 100, initial_indent="  ", subsequent_indent="  "))
        for knob in graph.interface.values():
            click.echo(f"    {knob.name:14} {_range(knob):24} {knob.help}")
        click.echo()
    click.echo("The paper's figures, with the paper's values:")
    for name, path in paper.items():
        said = json.loads(path.read_text(encoding="utf-8"))["description"]
        indent = f"  {name:9} "
        click.echo(textwrap.fill(said, 110, initial_indent=indent, subsequent_indent=" " * 12, break_on_hyphens=False))


def _load(path: Path) -> Graph:
    from flowabs_nodes import graph as graphs

    return graphs.load(path)


def _data(name: str, path: Path) -> dict[str, Any]:
    """Return what the listing says of a graph as JSON data; ``figure`` is true for one of the paper's figures."""
    graph = _load(path)
    knobs = [
        {
            "name": knob.name,
            "type": knob.type,
            "label": knob.param.label,
            "group": knob.group,
            "default": knob.default,
            "min": knob.min,
            "max": knob.max,
            "unit": knob.unit,
            "choices": list(knob.choices),
            "help": knob.help,
        }
        for knob in graph.interface.values()
    ]
    figure = path.parent.name == "paper"
    return {"name": name, "file": str(path), "figure": figure, "description": graph.description, "knobs": knobs}


def _range(knob: Knob) -> str:
    """Return a knob's range and, in brackets, its default: "0.5 to 2.5 px (1.0)"."""
    ends = f"{knob.min:g} to {knob.max:g}" if knob.min is not None and knob.max is not None else knob.param.expected
    words = " | ".join(knob.choices) if knob.choices else ends if knob.type in ("float", "int") else knob.type
    return f"{words}{' ' + knob.unit if knob.unit else ''} ({json.dumps(knob.default)})"
