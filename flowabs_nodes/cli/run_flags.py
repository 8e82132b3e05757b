"""Makes the command line's options of :class:`RunOptions`, for every command that describes a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, fields
from typing import Any

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.cli.once import OnceOption
from flowabs_nodes.engine.options import RunOptions, flag_of


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
    return (click.Option if flag.repeats else OnceOption)(
        names,
        type=kind,
        default=None if flag.repeats else option.default,
        is_flag=flag.type is bool,
        multiple=flag.repeats,
        metavar=flag.metavar,
        show_default=flag.show_default,
        callback=_PARSERS.get(option.name),
        shell_complete=completion.of_option(flag.metavar),
        help=flag.help,
    )


def with_run_options(command: click.Command) -> click.Command:
    """Give a command an option for each field of :class:`RunOptions`, before those that it declares itself."""
    return some_run_options(*(each.name for each in fields(RunOptions)))(command)


def some_run_options(*names: str) -> Callable[[click.Command], click.Command]:
    """Give a command an option for each of these fields of :class:`RunOptions`, before those of its own."""

    def give(command: click.Command) -> click.Command:
        own = [each for each in command.params if isinstance(each, click.Option)]
        arguments = [each for each in command.params if each not in own]
        declared = [_click_option(each) for each in fields(RunOptions) if each.name in names]
        command.params = [*arguments, *declared, *own]
        return command

    return give
