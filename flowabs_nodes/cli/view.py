"""``flowabs run GRAPH --view NODE``: writes a picture of any node of one frame, or shows it on the terminal."""

from __future__ import annotations

import json
import os
import sys
import time

import click

from flowabs_nodes.cli.progress import JsonLines, Lines
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError, FlowabsError

#: The longer side of a picture on a terminal, in pixels, at most.
_LONGEST = 1024


def view_node(graph: str, output: str, options: RunOptions, show: Lines) -> int:
    """Make the picture of an output, to a file where ``options`` name one, else on the terminal; return the exit code.

    ``show`` shows notes and where the picture went.

    Raises FlowabsError: CommandError where there is neither a file nor a terminal that shows pictures.
    """
    try:
        _view(graph, output, options, show)
    except FlowabsError as error:
        show.error(error)
        raise
    return 0


def _view(graph: str, output: str, options: RunOptions, show: Lines) -> None:
    """Make the picture, and show its notes and where it went."""
    from flowabs_nodes.cli import terminal_pictures
    from flowabs_nodes.engine.view import as_png, build_view

    start = time.perf_counter()
    as_json = isinstance(show, JsonLines)
    view = build_view(graph, output, options)
    escaped = None if as_json or not sys.stdout.isatty() else terminal_pictures.protocol(os.environ)
    if not view.file and escaped is None:
        where = "--json prints no picture" if as_json else "no terminal that shows pictures was found"
        raise CommandError(f"--view: {where}", code="no-output", hint="-o view.png names a file for it")
    picture = view.picture(show.event)
    if view.file:
        view.save(picture)
    elif escaped is not None:
        terminal = getattr(sys.stdout, "raw", sys.stdout)  # which obeys what everything else is kept from
        terminal.write(escaped(as_png(picture, _LONGEST)))
        terminal.flush()
    seconds = time.perf_counter() - start
    if as_json:
        event = {"event": "view", "frame": view.frame, "output": view.output, "file": view.file}
        click.echo(json.dumps({**event, "seconds": round(seconds, 4)}))
    else:
        show.line(f"frame {view.frame}  {view.output} {seconds:7.2f} s  {view.file}".rstrip())
