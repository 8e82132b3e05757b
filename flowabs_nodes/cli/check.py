"""``flowabs check``: says everything that is wrong with a graph."""

from __future__ import annotations

import json

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.cli.listings import warn_of_missing_nodes
from flowabs_nodes.engine.options import RunOptions, flag_of


@click.command()
@click.argument("graph", shell_complete=completion.graphs)
@click.option("--json", "as_json", is_flag=True, help="One JSON document: {ok, problems}.")
@click.option("--ocio", metavar="CONFIG", help=flag_of(RunOptions.__dataclass_fields__["ocio"]).help)
def check(graph: str, as_json: bool, ocio: str | None) -> int:
    """Say everything that is wrong with a GRAPH, or "ok".

    GRAPH is a file if it has a "/" or ends in .json, else a graph that comes with flowabs. Names of colour spaces are
    looked up in the OCIO config that flowabs run would use. Warnings alone exit 0.
    """
    from flowabs_nodes import graph as graphs
    from flowabs_nodes.color.config import opened
    from flowabs_nodes.engine.color_names import wrong_names
    from flowabs_nodes.engine.display_names import wrong_views
    from flowabs_nodes.engine.ocio_choice import choose_config

    warn_of_missing_nodes()
    options, notes = choose_config(RunOptions(ocio=ocio))
    problems = graphs.check(graph)
    if all(problem.warning for problem in problems):
        loaded, config = graphs.load(graph), opened(options.ocio)
        problems = [*problems, *wrong_names(loaded, config), *wrong_views(loaded, config)]
    errors = sum(not problem.warning for problem in problems)
    if as_json:
        click.echo(json.dumps({"ok": not errors, "problems": [problem.to_dict() for problem in problems]}, indent=2))
        return 2 if errors else 0
    for note in notes:
        click.echo(f"{note}\n")
    for problem in problems:
        click.echo(problem.block + "\n")
    warnings = len(problems) - errors
    counts = [f"{n} {word}{'' if n == 1 else 's'}" for n, word in ((errors, "error"), (warnings, "warning")) if n]
    click.echo(", ".join(counts) if errors else ", ".join(["ok", *counts]))
    return 2 if errors else 0
