"""Connects with Dask's scheduler, or starts workers of its own on this machine, and can be stopped while it does."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, wait
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any, TypeVar

from flowabs_nodes import stopping
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError
from flowabs_nodes.simd import bands

#: Seconds until a scheduler has answered, and has a worker.
CONNECT = 10.0

Made = TypeVar("Made")


@contextmanager
def connected_client(options: RunOptions, frames: int) -> Iterator[Any]:
    """Give Dask's client, closed at the end, and the workers on this machine with it."""
    try:
        from distributed import Client
    except ImportError as error:
        raise CommandError(
            "--scheduler needs Dask, which is not installed here",
            code="no-dask",
            hint='pip install "flowabs-nodes[dask]"',
        ) from error
    how: dict[str, Any] = {"set_as_default": False, "timeout": CONNECT}
    cluster = None
    if options.scheduler == "local":
        cluster = _local_cluster(min(options.jobs or options.threads or bands.thread_count(), max(1, frames)))
    else:
        stoppable(partial(_check_scheduler, str(options.scheduler)))
    try:
        try:
            client = stoppable(lambda: Client(cluster or options.scheduler, **how), otherwise=_close)
        except (OSError, TimeoutError) as error:
            raise nobody(str(options.scheduler)) from error
        try:
            yield client
        finally:
            _close(client)
    finally:
        if cluster is not None:
            with suppress(OSError, TimeoutError):
                cluster.close(timeout=5)


def _local_cluster(jobs: int) -> Any:
    """Return Dask's LocalCluster of ``jobs`` workers with one thread each, made so that nobody else can reach it.

    Scheduler and workers are threads of this process and talk within it; a frame's process is all that is started.
    (LocalCluster itself would have their web servers, which Dask always starts, listen on all networks.)
    """
    import dask
    from distributed import Scheduler, SpecCluster, Worker

    no_web = {"dashboard": False, "dashboard_address": "127.0.0.1:0", "protocol": "inproc://"}
    worker = {"cls": Worker, "options": {"nthreads": 1, "memory_limit": 0, **no_web}}
    with dask.config.set({f"distributed.{each}.http.routes": [] for each in ("scheduler", "worker")}):
        return SpecCluster(
            scheduler={"cls": Scheduler, "options": no_web},
            workers=dict.fromkeys(range(jobs), worker),
            silence_logs=False,
        )


def _check_scheduler(address: str) -> None:
    """Raise CommandError where nobody answers at an address, or something else than a scheduler of Dask."""
    from distributed.comm import connect
    from distributed.core import send_recv

    async def ask() -> Any:
        comm = await connect(address, timeout=CONNECT)
        try:
            return await send_recv(comm, op="identity")
        finally:
            comm.abort()

    async def in_time() -> Any:
        return await asyncio.wait_for(ask(), CONNECT)  # Dask itself waits for ever for one that says nothing

    try:
        found = asyncio.run(in_time())["type"]
    except (OSError, TimeoutError) as error:
        raise nobody(address) from error
    except Exception as error:  # whatever is made of another protocol, or of another version of Dask's
        raise _no_scheduler(address, type(error).__name__) from error
    if found != "Scheduler":
        raise _no_scheduler(address, f"it is a {found}")


def stoppable(work: Callable[[], Made], otherwise: Callable[[Made], object] = lambda made: None) -> Made:
    """Return what ``work`` does, unless the run is to stop meanwhile; ``otherwise`` gets it then, when it is there.

    Raises what ``work`` raises, and Stopped.
    """
    future: Future[Made] = Future()

    def fulfil() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # noqa: BLE001 - raised again by whoever asks for the result
            future.set_exception(error)

    threading.Thread(target=fulfil, name="flowabs-dask", daemon=True).start()
    while not wait([future], 0.1).done:
        try:
            stopping.check()
        except BaseException:
            future.add_done_callback(lambda done: done.exception() or otherwise(done.result()))
            raise
    return future.result()


def _close(client: Any) -> None:
    """Close Dask's client, whatever has become of its scheduler."""
    with suppress(OSError, TimeoutError):
        client.close(timeout=2)


@contextmanager
def quiet() -> Iterator[None]:
    """Have Dask log nothing: what is to be said is said by events."""
    with suppress(ImportError):  # told by whoever needs it
        import distributed  # noqa: F401 - which says how each of its parts logs
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.startswith("distributed")]
    before = [(logger, logger.level) for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in before:
            logger.setLevel(level)


def nobody(scheduler: str) -> CommandError:
    """Return the error that says that no scheduler answers."""
    return CommandError(
        f"--scheduler {scheduler}: no scheduler of Dask answers within {CONNECT:g} s",
        code="no-scheduler",
        hint="start one with `dask scheduler`, which says its address",
    )


def _no_scheduler(address: str, why: str) -> CommandError:
    text = f"--scheduler {address}: what answers there is no scheduler of Dask that can be talked to ({why})"
    return CommandError(text, code="no-scheduler", hint="`dask scheduler` says its address")
