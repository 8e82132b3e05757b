"""``flowabs run``: runs a graph over frames."""

from __future__ import annotations

from functools import partial
from typing import Any

import click

from flowabs_nodes.cli import completion
from flowabs_nodes.cli.listings import warn_of_missing_nodes
from flowabs_nodes.cli.once import OnceOption
from flowabs_nodes.cli.run_flags import with_run_options
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import FlowabsError

#: Where a context holds the words after "flowabs run".
_WORDS = "flowabs.words"

_COMPILING = "kernels are being compiled, which can take a minute: they are kept on disk for all later runs"


class _RunCommand(click.Command):
    """Keeps the words that it is called with, to show a command that makes frames again."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as any command does."""
        ctx.meta[_WORDS] = tuple(args)
        return super().parse_args(ctx, args)


@with_run_options
@click.command(cls=_RunCommand)
@click.argument("graph", shell_complete=completion.graphs)
@click.option("--json", "as_json", is_flag=True, help="One event a line on stdout.")
@click.option("--profile", is_flag=True, help="Show the seconds that each node took; with -v of each frame too.")
@click.option(
    "--view",
    cls=OnceOption,
    metavar="NODE[.OUTPUT]",
    help="Look at a node on the first frame: -o names a PNG or TIFF, else the terminal shows it. Nothing else is made.",
)
@click.option(
    "--dry-run",
    is_flag=True,
    help="Tell what would be read, written and done, from names, times and headers alone. Nothing is made.",
)
@click.option("-v", "--verbose", is_flag=True, help="Say more: each node, what is read and what is there already.")
@click.option("-q", "--quiet", is_flag=True, help="Say failures and warnings only.")
@click.option("--log-file", cls=OnceOption, metavar="FILE", help="Append every line to FILE too, with the time.")
def run(
    graph: str,
    as_json: bool,
    profile: bool,
    view: str | None,
    dry_run: bool,
    verbose: bool,
    quiet: bool,
    log_file: str | None,
    **options: Any,
) -> int:
    """Run a GRAPH over frames: EXR in, EXR out.

    GRAPH is a file if it has a "/" or ends in .json, else a graph that comes with flowabs (see flowabs graphs).

    Exit codes: 0 every frame is there, 1 one is not, 2 the graph or the command is wrong, 130 and 143 stopped.
    """
    from flowabs_nodes.cli.bar import Bar
    from flowabs_nodes.cli.log_file import LogFile, open_log
    from flowabs_nodes.cli.precompile import compiling_ahead
    from flowabs_nodes.cli.progress import JsonLines, Lines, Loudness, on_a_terminal
    from flowabs_nodes.cli.rerun import command_for
    from flowabs_nodes.cli.shows import Shows
    from flowabs_nodes.engine.render_sequence import render_sequence
    from flowabs_nodes.engine.report import Note, note_event
    from flowabs_nodes.simd import compile_hooks
    from flowabs_nodes.simd.target import kernel_path

    context = click.get_current_context()
    if verbose and quiet:
        raise click.UsageError("-v says more and -q says less: give one of them", context)
    words: tuple[str, ...] = context.meta[_WORDS]
    loudness = Loudness.VERBOSE if verbose else Loudness.QUIET if quiet else Loudness.NORMAL
    again = partial(command_for, words)
    if dry_run:
        from flowabs_nodes.cli.dry_run import tell_plan

        if profile or log_file is not None or view is not None:
            raise click.UsageError("--profile, --log-file and --view make something: --dry-run makes nothing", context)
        kernel_path()
        return tell_plan(graph, RunOptions(**options), (JsonLines if as_json else Lines)(loudness, again))
    if view is not None:
        from flowabs_nodes.cli.view import view_node

        if profile or log_file is not None:
            raise click.UsageError("--profile and --log-file are of a whole run: they do not go with --view", context)
        if options["scheduler"] is not None:
            raise click.UsageError("--view makes its one picture here: it does not go with --scheduler", context)
        kernel_path()
        with compiling_ahead(graph, options["set"]):
            return view_node(graph, view, RunOptions(**options), (JsonLines if as_json else Lines)(loudness, again))
    kind = JsonLines if as_json else Bar if on_a_terminal() and not quiet else Lines
    logs = []
    if log_file is not None:
        logs = [LogFile(open_log(log_file, graph=graph, root=options["root"]), loudness, again, words)]
    with Shows(kind(loudness, again), *logs) as show, compiling_ahead(graph, options["set"]):
        kernel_path()  # what is wrong with FLOWABS_SIMD is wrong for every frame
        warn_of_missing_nodes()
        compile_hooks.waiting.append(lambda: show.event(note_event(Note(_COMPILING))))
        try:
            report = render_sequence(graph, RunOptions(**options), profile=profile, on_event=show.event)
        except FlowabsError as error:
            show.error(error)
            raise
        show.end(report)
    return report.exit_code
