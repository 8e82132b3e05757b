"""``flowabs nodes``, ``flowabs schema``, ``flowabs graphs``: list what there is to use."""

from __future__ import annotations

import json
import textwrap
from typing import TYPE_CHECKING

import click

from flowabs_nodes.errors import CommandError, nearest

if TYPE_CHECKING:
    from flowabs_nodes.graph.model import Knob


@click.command()
@click.argument("type", required=False)
def nodes(type: str | None) -> None:
    """The nodes that are installed, or the page of one TYPE: ports, parameters, ranges."""
    from flowabs_nodes.nodes import catalogue, describe

    warn_of_missing_nodes()
    known = catalogue()
    if type is None:
        click.echo(describe.listing(known.values()))
        return
    node = known.get(type.partition("@")[0])
    if node is None or type not in (node.type, node.name):
        hint = nearest(type, known if node is None else [node.name])
        raise CommandError(f"no node {type!r} is installed", code="unknown-type", hint=hint)
    click.echo(describe.page(node))


@click.command()
def schema() -> None:
    """The JSON Schema of graph files of the nodes that are installed: completion and checks in an editor."""
    from flowabs_nodes import graph as graphs

    warn_of_missing_nodes()
    click.echo(json.dumps(graphs.schema(), indent=2, ensure_ascii=False))


@click.command()
def graphs() -> None:
    """The graphs that come with flowabs, and the knobs of each (set one with --set knob=value)."""
    from flowabs_nodes import graph as graphs
    from flowabs_nodes.graph.shipped import paper

    for name, path in graphs.shipped().items():
        graph = graphs.load(path)
        click.echo(name)
        click.echo(textwrap.fill(graph.description, 100, initial_indent="  ", subsequent_indent="  "))
        for knob in graph.interface.values():
            click.echo(f"    {knob.name:14} {_range(knob):24} {knob.help}")
        click.echo()
    click.echo("The paper's figures, with the paper's values:")
    for name, path in paper().items():
        said = json.loads(path.read_text(encoding="utf-8"))["description"]
        indent = f"  {name:9} "
        click.echo(textwrap.fill(said, 110, initial_indent=indent, subsequent_indent=" " * 12, break_on_hyphens=False))


def _range(knob: Knob) -> str:
    """Return a knob's range and, in brackets, its default: "0.5 to 2.5 px (1.0)"."""
    ends = f"{knob.min:g} to {knob.max:g}" if knob.min is not None and knob.max is not None else knob.param.expected
    words = " | ".join(knob.choices) if knob.choices else ends if knob.type in ("float", "int") else knob.type
    return f"{words}{' ' + knob.unit if knob.unit else ''} ({json.dumps(knob.default)})"


def warn_of_missing_nodes() -> None:
    """Say on stderr which packages' nodes could not be loaded, and why."""
    from flowabs_nodes.nodes import load_problems

    for where, why in load_problems().items():
        click.echo(f"flowabs: warning: nodes left out, {where}: {why}", err=True)
