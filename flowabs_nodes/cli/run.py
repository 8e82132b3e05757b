"""``flowabs run``: a graph over frames."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from flowabs_nodes.choices import EXISTING, MISSING
from flowabs_nodes.cli.listings import warn_of_missing_nodes
from flowabs_nodes.errors import FlowabsError


def _settings(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> dict[str, Any]:
    """--set name=value, each value JSON if it parses, else a text. Of two for one name the later counts."""
    from flowabs_nodes.graph import parse_setting

    settings = {}
    for text in values:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise click.BadParameter(f"{text!r} is not knob=value or node.parameter=value")
        settings[name] = parse_setting(value)
    return settings


@click.command()
@click.argument("graph")
@click.option("-i", "--input", metavar="FILE", help="File or sequence of the graph's only read: shot.####.exr.")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    multiple=True,
    help="File or sequence of the graph's only write. Again: the same image in that file's format too.",
)
@click.option("--frames", metavar="RANGE", help="1001-1100x2,1200. Without it: every frame on disk.")
@click.option(
    "--set",
    "settings",
    metavar="NAME=VALUE",
    multiple=True,
    callback=_settings,
    help="Set a knob, or any parameter as node.parameter. JSON if it parses, else a text.",
)
@click.option(
    "--existing",
    type=click.Choice(EXISTING),
    default="resume",
    show_default=True,
    help="About files that are there: resume keeps what is whole and was made from the same.",
)
@click.option(
    "--missing",
    type=click.Choice(MISSING),
    help="About frames of the plate that are not there; else as the graph says.",
)
@click.option("--scale", type=float, default=1.0, help="Filter a smaller picture, with lengths to match: 0.5 is half.")
@click.option("--root", type=Path, metavar="DIR", help="Read and write nothing outside DIR, links included.")
@click.option("--max-pixels", type=click.IntRange(min=1), metavar="N", help="Refuse larger pictures.")
@click.option("--ocio", metavar="CONFIG", help="An OpenColorIO config instead of the built-in one.")
@click.option("--json", "as_json", is_flag=True, help="One event a line on stdout.")
@click.option("--profile", is_flag=True, help="Show the seconds that each node took.")
def run(
    graph: str,
    input: str | None,
    output: tuple[str, ...],
    frames: str | None,
    settings: dict[str, Any],
    existing: str,
    missing: str | None,
    scale: float,
    root: Path | None,
    max_pixels: int | None,
    ocio: str | None,
    as_json: bool,
    profile: bool,
) -> int:
    """Run a GRAPH over frames: EXR in, EXR out.

    GRAPH is a file if it has a "/" or ends in .json, else a graph that comes with flowabs (see flowabs graphs).

    Exit codes: 0 every frame is there, 1 one is not, 2 the graph or the command is wrong, 130 and 143 stopped.
    """
    from flowabs_nodes import engine
    from flowabs_nodes.cli.precompile import compiling_ahead
    from flowabs_nodes.cli.progress import Bar, JsonLines, Lines, on_a_terminal
    from flowabs_nodes.io.settings import Settings
    from flowabs_nodes.simd.target import kernel_path

    kernel_path()  # what is wrong with FLOWABS_SIMD is wrong for every frame
    warn_of_missing_nodes()
    given: dict[str, Any] = {"max_pixels": max_pixels, "ocio": ocio, "root": root}
    with (
        (JsonLines if as_json else Bar if on_a_terminal() else Lines)() as show,
        compiling_ahead(graph, settings),
    ):
        try:
            report = engine.run(
                graph,
                input=input,
                output=list(output) or None,
                frames=frames,
                set=settings or None,
                scale=scale,
                existing=existing,
                missing=missing,
                profile=profile,
                settings=Settings(**{name: value for name, value in given.items() if value is not None}),
                on_event=show.event,
            )
        except FlowabsError as error:
            show.error(error)
            raise
        show.end(report)
    return report.exit_code
