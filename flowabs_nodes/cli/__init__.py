"""The command line: gathers the commands, and turns whatever goes wrong into a message and an exit code.

Exit codes: 0 all is well; 1 a frame is missing, damaged, or not written; 2 the graph or the command is wrong;
130, 143 stopped by a signal.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, NoReturn

import click

import flowabs_nodes
from flowabs_nodes import stopping
from flowabs_nodes.cli import shells
from flowabs_nodes.cli.check import check
from flowabs_nodes.cli.colorspaces import colorspaces
from flowabs_nodes.cli.graph_listing import graphs
from flowabs_nodes.cli.listings import nodes, schema
from flowabs_nodes.cli.openfx import openfx
from flowabs_nodes.cli.run import run
from flowabs_nodes.cli.serve import serve
from flowabs_nodes.cli.streams import safe_streams
from flowabs_nodes.cli.submit import openjd_task, submit
from flowabs_nodes.engine.error_boundary import InternalError
from flowabs_nodes.errors import FlowabsError, ReadError, WriteError
from flowabs_nodes.signals import stop_on_signals


def _show_version(context: click.Context, option: click.Parameter, value: bool) -> None:
    """Print the version and the kernel path, and end, where ``--version`` is given."""
    if value:
        from flowabs_nodes.simd.target import PATH

        click.echo(f"flowabs {flowabs_nodes.__version__} (kernels: {PATH})")
        context.exit()


class _Commands(click.Group):
    """The commands; one that a signal has stopped returns its exit code."""

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except stopping.Stopped as stopped:  # click would print an empty line, into a log or a host's messages too
            if sys.stderr.isatty():
                print(file=sys.stderr)  # after the ^C that the terminal shows
            return stopped.exit_code


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_show_version,
    help="Show the version, and which vector instructions the kernels use.",
)
def cli() -> None:
    """Line drawings, flat colour and cartoons from scene-linear EXR plates, by graphs of image nodes.

    A first picture: flowabs run abstraction -i plate.exr -o toon.exr
    """


for command in (run, check, nodes, schema, graphs, colorspaces, submit, openjd_task, openfx, serve):
    cli.add_command(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command, and return the exit code of the process.

    Errors are told on stderr, without a traceback. ``arguments`` default to those of the process. A command whose
    output cannot be printed has failed, unless it makes frames: these are made, and the exit code tells of them alone.
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    makes_frames = words[:1] in (["run"], ["openjd-task"])
    with safe_streams(readers_may_leave=not makes_frames) as out:
        code = _exit_code(words)
    lost = bool(out.trouble) and not out.reader_left and not makes_frames
    return code or int(lost)


def _exit_code(arguments: Sequence[str]) -> int:
    """Run a command, tell what goes wrong, and return the exit code that tells of it."""
    shells.register()
    try:
        with stop_on_signals():
            code = cli.main(arguments, prog_name="flowabs", standalone_mode=False)
            stopping.check()
        return code if isinstance(code, int) else 0
    except stopping.Stopped as stopped:
        return stopped.exit_code
    except click.Abort:  # what click makes of Ctrl-C where nobody listens to signals
        return 128 + signal.SIGINT
    except click.ClickException as error:
        error.show()
        return 2
    except FlowabsError as error:
        print(f"flowabs: {error}", file=sys.stderr)
        return 1 if isinstance(error, ReadError | WriteError | InternalError) else 2
    except OSError as error:
        print(f"flowabs: {error}", file=sys.stderr)
        return 1


def run_process() -> NoReturn:
    """Run the command that the process was started with, and end the process."""
    gc.set_threshold(50_000)  # imports and compilation make many objects, and hardly any of them garbage
    code = main()
    others = (thread for thread in threading.enumerate() if thread is not threading.main_thread())
    if not all(thread.daemon or thread.name.startswith("flowabs") for thread in others):
        sys.exit(code)  # waits for the threads of a foreign node
    # Python's own exit takes all modules apart, object by object: that lasts longer than a picture of 512 x 512.
    atexit._run_exitfuncs()
    for stream in filter(None, (sys.stdout, sys.stderr)):
        with suppress(OSError):  # main has said that nothing can be printed
            stream.flush()
    os._exit(code)
