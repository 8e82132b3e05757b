"""``flowabs run``: runs a graph over frames."""

from __future__ import annotations

from dataclasses import Field, fields
from typing import Any

import click

from flowabs_nodes.cli.listings import warn_of_missing_nodes
from flowabs_nodes.engine.options import RunOptions, flag_of
from flowabs_nodes.errors import FlowabsError


def _parse_settings(context: click.Context, option: click.Parameter, values: tuple[str, ...]) -> dict[str, Any]:
    """Parse the values of ``--set name=value``: each value is JSON if it parses, else a text; later ones win."""
    from flowabs_nodes.graph import parse_setting

    settings = {}
    for text in values:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise click.BadParameter(f"{text!r} is not knob=value or node.parameter=value")
        settings[name] = parse_setting(value)
    return settings


#: How the values of options are parsed whose text is more than one value.
_PARSERS = {"set": _parse_settings}


def _click_option(option: Field[Any]) -> click.Option:
    """Make the command line's option of a field of :class:`RunOptions`."""
    flag = flag_of(option)
    names = [option.name, f"--{option.name.replace('_', '-')}", *filter(None, [flag.short])]
    kind: Any = flag.type
    if flag.choices:
        kind = click.Choice(flag.choices)
    elif flag.min is not None:
        kind = click.IntRange(min=flag.min)
    return click.Option(
        names,
        type=kind,
        default=None if flag.repeats else option.default,
        is_flag=flag.type is bool,
        multiple=flag.repeats,
        metavar=flag.metavar,
        show_default=flag.show_default,
        callback=_PARSERS.get(option.name),
        help=flag.help,
    )


def _takes_run_options(command: click.Command) -> click.Command:
    """Give a command an option for each field of :class:`RunOptions`, before those that it declares itself."""
    own = [each for each in command.params if isinstance(each, click.Option)]
    arguments = [each for each in command.params if each not in own]
    command.params = [*arguments, *map(_click_option, fields(RunOptions)), *own]
    return command


@_takes_run_options
@click.command()
@click.argument("graph")
@click.option("--json", "as_json", is_flag=True, help="One event a line on stdout.")
@click.option("--profile", is_flag=True, help="Show the seconds that each node took.")
@click.option(
    "--view",
    metavar="NODE[.OUTPUT]",
    help="Look at a node on the first frame: -o names a PNG or TIFF, else the terminal shows it. Nothing else is made.",
)
def run(graph: str, as_json: bool, profile: bool, view: str | None, **options: Any) -> int:
    """Run a GRAPH over frames: EXR in, EXR out.

    GRAPH is a file if it has a "/" or ends in .json, else a graph that comes with flowabs (see flowabs graphs).

    Exit codes: 0 every frame is there, 1 one is not, 2 the graph or the command is wrong, 130 and 143 stopped.
    """
    from flowabs_nodes.cli.precompile import compiling_ahead
    from flowabs_nodes.cli.progress import Bar, JsonLines, Lines, on_a_terminal
    from flowabs_nodes.engine.render_sequence import render_sequence
    from flowabs_nodes.simd.target import kernel_path

    kernel_path()  # what is wrong with FLOWABS_SIMD is wrong for every frame
    warn_of_missing_nodes()
    if view is not None:
        from flowabs_nodes.cli.view import view_node

        if profile:
            raise click.UsageError("--profile is of a whole run: it does not go with --view")
        with compiling_ahead(graph, options["set"]):
            return view_node(graph, view, RunOptions(**options), as_json=as_json)
    with (
        (JsonLines if as_json else Bar if on_a_terminal() else Lines)() as show,
        compiling_ahead(graph, options["set"]),
    ):
        try:
            report = render_sequence(graph, RunOptions(**options), profile=profile, on_event=show.event)
        except FlowabsError as error:
            show.error(error)
            raise
        show.end(report)
    return report.exit_code
