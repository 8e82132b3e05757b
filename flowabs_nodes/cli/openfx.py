"""``flowabs openfx``: builds the plug-in for Nuke, Resolve, Natron and other hosts of OpenFX."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from flowabs_nodes.cli.once import OnceOption

Command = Callable[..., Any]


def _out(command: Command) -> Command:
    """Add the option that says where the bundle is."""
    option = click.option(
        "--out",
        cls=OnceOption,
        type=Path,
        metavar="DIR",
        help="The folder of the bundle: one of OFX_PLUGIN_PATH. Default: OFX/Plugins in your home.",
    )
    return option(command)


@click.group()
def openfx() -> None:
    """Build the OpenFX plug-in: one effect for each graph, for Nuke, Resolve, Natron and others."""


@openfx.command()
@_out
def build(out: Path | None) -> None:
    """Compile the plug-in with $CC or cc, and describe each graph to it, those in FLOWABS_GRAPHS too."""
    from flowabs_nodes.openfx import bundle

    _tell(*bundle.build(out or bundle.default_folder()))


@openfx.command()
@_out
def refresh(out: Path | None) -> None:
    """Describe the graphs anew, after one was added or its knobs have changed; nothing is compiled."""
    from flowabs_nodes.openfx import bundle

    _tell(*bundle.refresh(out or bundle.default_folder()))


@openfx.command()
def path() -> None:
    """Print the folder for OFX_PLUGIN_PATH, where bundles are built unless --out says another."""
    from flowabs_nodes.openfx import bundle

    click.echo(bundle.default_folder())


def _tell(bundle: Path, problems: list[str]) -> None:
    """Print where the bundle is, and which graphs are no effects."""
    for problem in problems:
        click.echo(f"flowabs: no effect: {problem}", err=True)
    click.echo(bundle)
