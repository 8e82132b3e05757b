"""``flowabs serve``: filters pictures for hosts, over pipes or shared memory."""

from __future__ import annotations

import json
import os
import sys
import threading
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import click

from flowabs_nodes.cli.once import OnceOption
from flowabs_nodes.cli.run_flags import some_run_options
from flowabs_nodes.engine.memory import parse_memory
from flowabs_nodes.errors import CommandError
from flowabs_nodes.stopping import Stopped

if TYPE_CHECKING:
    from flowabs_nodes.serve.server import Server

_COMPILING = "flowabs: kernels are being compiled, which can take a minute: they are kept on disk for later"

_LAST_SECONDS = 0.7  # after the end, for what other packages have at work


@some_run_options("threads", "max_pixels", "ocio")
@click.command()
@click.option(
    "--socket",
    "path",
    cls=OnceOption,
    type=Path,
    metavar="PATH",
    help="Serve several clients on a Unix socket, in a folder of this user alone.",
)
@click.option(
    "--port",
    cls=OnceOption,
    type=click.IntRange(0, 65535),
    metavar="N",
    help="Serve several clients on this machine, 127.0.0.1, on a port; 0 is any that is free.",
)
@click.option(
    "--cache",
    cls=OnceOption,
    default="1GB",
    show_default=True,
    metavar="SIZE",
    help="What results and pictures of all sessions may take: 1GB, 10%.",
)
@click.option(
    "--sessions",
    cls=OnceOption,
    type=click.IntRange(min=1),
    default=64,
    show_default=True,
    metavar="N",
    help="How many sessions to hold; the one unused longest is let go.",
)
def serve(
    path: Path | None,
    port: int | None,
    cache: str,
    sessions: int,
    threads: int | None,
    max_pixels: int,
    ocio: str | None,
) -> int:
    """Filter pictures for a host: a compositor, Blender, another program. The host starts it.

    Without --socket or --port it talks over stdin and stdout to the program that started it, and to no one else. With
    one of them it prints its address and a token in a line of JSON; $FLOWABS_TOKEN, if set, is the token. It ends when
    stdin does, if that is a pipe: when the host has died.
    """
    from flowabs_nodes.serve.framing import greeting
    from flowabs_nodes.serve.listening import listening_port, listening_socket, token
    from flowabs_nodes.serve.streams import host_streams, watch_end

    context = click.get_current_context()
    if path is not None and port is not None:
        raise click.UsageError("--socket and --port: give one of them", context)
    alone = path is None and port is None
    if alone and sys.stdin.isatty():
        raise click.UsageError("a host talks to it over pipes: --socket or --port serve others", context)
    from flowabs_nodes.simd import compile_hooks
    from flowabs_nodes.simd.target import kernel_path

    kernel_path()
    server = _server(cache, sessions, threads, max_pixels, ocio)
    compile_hooks.waiting.append(lambda: print(_COMPILING, file=sys.stderr, flush=True))
    with ExitStack() as until_the_end:
        secret = "" if alone else token()
        if path is not None:
            listener, address = until_the_end.enter_context(listening_socket(path))
        elif port is not None:
            listener, address = until_the_end.enter_context(listening_port(port))
        host = host_streams()
        if alone:
            server.serve_host(host.reads, host.writes)
        else:
            line = json.dumps({**greeting(), "address": address, "token": secret}) + "\n"
            with suppress(BrokenPipeError):  # nobody wants to know
                host.writes.write(memoryview(line.encode()))
            server.serve_clients(listener, secret)
            if host.piped:
                watch_end(host.reads, server.end)
        code = 2  # where the host sent what is no message
        try:
            server.wait()
            code = 0
        except Stopped as stopped:
            code = stopped.exit_code
            raise
        finally:
            _end_soon(code)
    return code


def _server(cache: str, sessions: int, threads: int | None, max_pixels: int, ocio: str | None) -> Server:
    """Return the server that these options ask for. Raises FlowabsError for a wrong size or config."""
    from flowabs_nodes.engine.ocio_choice import choose_config
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.serve.server import Server
    from flowabs_nodes.serve.sessions import Sessions

    options = RunOptions(threads=threads, max_pixels=max_pixels, ocio=ocio)
    choose_config(options)  # what is wrong with it is wrong for every render
    try:
        cache_bytes = parse_memory(cache)
    except ValueError as error:
        raise CommandError(f"cache: {error}", code="bad-value", parameter="cache") from None
    return Server(Sessions(sessions, cache_bytes, options.threads, options.settings), max_pixels)


def _end_soon(code: int) -> None:
    """End the process in a moment, also where a thread of another package is still at work."""
    timer = threading.Timer(_LAST_SECONDS, os._exit, [code])
    timer.daemon = True
    timer.start()
