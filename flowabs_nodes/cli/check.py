"""``flowabs check``: says everything that is wrong with a graph."""

from __future__ import annotations

import json

import click

from flowabs_nodes.cli.listings import warn_of_missing_nodes


@click.command()
@click.argument("graph")
@click.option("--json", "as_json", is_flag=True, help="One JSON document: {ok, problems}.")
def check(graph: str, as_json: bool) -> int:
    """Say everything that is wrong with a GRAPH, or "ok".

    GRAPH is a file if it has a "/" or ends in .json, else a graph that comes with flowabs. Warnings alone exit 0.
    """
    from flowabs_nodes import graph as graphs
    from flowabs_nodes.engine.display_names import wrong_views

    warn_of_missing_nodes()
    problems = graphs.check(graph)
    if all(problem.warning for problem in problems):
        problems = [*problems, *wrong_views(graphs.load(graph), None)]
    errors = sum(not problem.warning for problem in problems)
    if as_json:
        click.echo(json.dumps({"ok": not errors, "problems": [problem.to_dict() for problem in problems]}, indent=2))
        return 2 if errors else 0
    for problem in problems:
        click.echo(problem.block + "\n")
    warnings = len(problems) - errors
    counts = [f"{n} {word}{'' if n == 1 else 's'}" for n, word in ((errors, "error"), (warnings, "warning")) if n]
    click.echo(", ".join(counts) if errors else ", ".join(["ok", *counts]))
    return 2 if errors else 0
