"""``flowabs submit``: writes what hands a run to a render farm; ``flowabs openjd-task`` is what the farm calls then."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.cli.listings import warn_of_missing_nodes
from flowabs_nodes.cli.once import OnceOption
from flowabs_nodes.cli.run_flags import with_run_options
from flowabs_nodes.engine.options import RunOptions


@click.group()
def submit() -> None:
    """Write a job for a render farm, from the words of a run."""


@with_run_options
@submit.command()
@click.argument("graph", shell_complete=completion.graphs)
@click.option(
    "--chunk",
    cls=OnceOption,
    type=click.IntRange(min=1),
    help="Frames of one task; without it 10, and 24 for a graph that reads frames around each.",
)
def openjd(graph: str, chunk: int | None, **options: Any) -> None:
    """Print an Open Job Description template of a run: flowabs submit openjd GRAPH ... > job.json

    Save it in the current folder: names of files are relative to the folder that it is in. Its tasks call flowabs,
    which has to be installed on the machines of the farm.
    """
    from flowabs_nodes.submit.openjd_template import job_template

    warn_of_missing_nodes()
    template = job_template(graph, RunOptions(**options), chunk=chunk)
    click.echo(json.dumps(template, indent=2))


@with_run_options
@click.command("openjd-task", hidden=True)
@click.argument("graph")
@click.option("--folder", type=Path, metavar="DIR", help="Where names of files begin that are not absolute.")
def openjd_task(graph: str, folder: Path | None, **options: Any) -> int:
    """Run a GRAPH as a task of a job that flowabs submit openjd wrote, over --frames in the form of OpenJD."""
    from flowabs_nodes.cli.precompile import compiling_ahead
    from flowabs_nodes.simd.target import kernel_path
    from flowabs_nodes.submit.openjd_task import enter, failing, run_task

    with failing():
        enter(folder)
        kernel_path()
        warn_of_missing_nodes()
        with compiling_ahead(graph, options["set"]):
            return run_task(graph, options)
