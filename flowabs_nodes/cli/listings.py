"""``flowabs nodes`` and ``flowabs schema``: list the nodes that are installed, for people and for programs."""

from __future__ import annotations

import json

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.errors import CommandError, nearest


@click.command()
@click.argument("type", required=False, shell_complete=completion.nodes)
@click.option("--json", "as_json", is_flag=True, help="One JSON document: ports and parameters of each node.")
def nodes(type: str | None, as_json: bool) -> None:
    """The nodes that are installed, or the page of one TYPE: ports, parameters, ranges."""
    from flowabs_nodes.nodes import as_data, catalogue, describe

    warn_of_missing_nodes()
    known = catalogue()
    if type is None:
        listed = [as_data.node_data(node) for node in known.values()]
        click.echo(_json(listed) if as_json else describe.listing(known.values()))
        return
    node = known.get(type.partition("@")[0])
    if node is None or type not in (node.type, node.name):
        hint = nearest(type, known if node is None else [node.name])
        raise CommandError(f"no node {type!r} is installed", code="unknown-type", hint=hint)
    click.echo(_json(as_data.node_data(node)) if as_json else describe.page(node))


@click.command()
def schema() -> None:
    """The JSON Schema of graph files of the nodes that are installed: completion and checks in an editor."""
    from flowabs_nodes import graph as graphs

    warn_of_missing_nodes()
    click.echo(_json(graphs.schema()))


def _json(data: object) -> str:
    return json.dumps(data, indent=2, ensure_ascii=False)


def warn_of_missing_nodes() -> None:
    """Say on stderr which packages' nodes could not be loaded, and why."""
    from flowabs_nodes.nodes import load_problems

    for where, why in load_problems().items():
        click.echo(f"flowabs: warning: nodes left out, {where}: {why}", err=True)
