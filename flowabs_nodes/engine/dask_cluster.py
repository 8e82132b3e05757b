"""Connects a run with Dask's scheduler, or one of its own on this machine, and finds out which workers can serve it.

A worker needs this very version of the package, and the same files under the same names. One that has not is passed
over, and a warning says why; where no worker can do anything, the run is refused before it has made anything.
"""

from __future__ import annotations

import os
import pickle
import secrets
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from flowabs_nodes import __version__, stopping
from flowabs_nodes.engine import dask_connection
from flowabs_nodes.engine.dask_connection import connected_client, nobody, quiet, stoppable
from flowabs_nodes.engine.dask_worker import Place, look_around
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.memory import SHARE, available_memory, resident
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.plan import file_role
from flowabs_nodes.engine.report import Note
from flowabs_nodes.engine.sources import file_of
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.claim_files import HOST
from flowabs_nodes.io.sequences import Sequence as Files

_START = "start workers with `dask worker {}`, in an environment that has flowabs-nodes"


class DaskCluster:
    """The workers that a run may use. ``client`` is Dask's, ``notes`` is what is to be said at the beginning.

    ``local``: they are on this machine, and this run's own.
    """

    def __init__(self, client: Any, job: Job, numbers: Sequence[int], options: RunOptions) -> None:
        self.client = client
        self.local = options.scheduler == "local"
        self.job = pickle.dumps(job, pickle.HIGHEST_PROTOCOL)
        self.folder = os.getcwd()
        self.places: dict[str, Place] = {}  # by address, also those that are refused
        self.notes: list[Note] = []
        self._memory = options.memory_bytes
        self._seen = _files_seen(job, numbers)
        self._folders = sorted({os.path.dirname(file) for files in job.outputs.values() for file in files})

    @property
    def usable(self) -> dict[str, Place]:
        """Return the workers that can render frames, by address."""
        return {address: place for address, place in self.places.items() if not place.refused}

    def look(self, *, again: bool = False) -> list[Note]:
        """Find out which workers there are now; return a warning about each new one that can do nothing.

        Workers that are known are not asked once more, unless ``again``.
        """
        there = set(self.client.nthreads())
        known = {} if again else {address: place for address, place in self.places.items() if address in there}
        new = sorted(there - known.keys())
        if new:
            known |= self._ask(new)
        self.places = known
        return [
            Note(f"Dask worker {address} is passed over: it {known[address].refused}", warning=True)
            for address in new
            if address in known and known[address].refused
        ]

    def room(self, peak: int, jobs: int | None) -> int:
        """Return how many frames may be rendered at once, if one takes ``peak`` bytes (0: not known yet)."""
        places = list(self.usable.values())
        if self.local:
            fit = (self.memory - resident()) // peak if peak else 1
            return max(1, min(fit, sum(place.threads for place in places)))
        fits = (min(each.threads, max(1, (self._memory or each.memory) // peak)) if peak else 1 for each in places)
        return min(sum(fits), jobs or sum(place.threads for place in places))

    @property
    def memory(self) -> int:
        """Return how many bytes all frames at once may take: of this machine, or of the smallest worker."""
        if self.local:
            return self._memory or int(SHARE * available_memory())
        return self._memory or min((place.memory for place in self.usable.values()), default=0)

    def _ask(self, addresses: list[str]) -> dict[str, Place]:
        """Ask workers what they are; one that does not answer has gone."""
        versions = self.client.run(_version_probe(), workers=addresses, on_error="return")
        found = {address: Place("", 0, 0, reason) for address, found in versions.items() if (reason := _misfit(found))}
        same = [address for address, version in versions.items() if version == __version__]
        if same:
            with self._marks() as marks:
                said = self.client.run(look_around, self.job, self.folder, marks, workers=same, on_error="return")
            for address, place in said.items():
                found[address] = place if isinstance(place, Place) else Place("", 0, 0, f"fails: {place}")
        return found

    @contextmanager
    def _marks(self) -> Iterator[Mapping[str, int]]:
        """Put a file beside the outputs, for a moment, and give the files that each worker has to see."""
        made: list[Path] = []
        try:
            for folder in self._folders:
                place = Path(self.folder, folder)
                while not place.is_dir() and place != place.parent:
                    place = place.parent
                mark = place / f".flowabs.{HOST}.{secrets.token_hex(8)}.probe"
                with suppress(OSError):  # a full disk: the frames will tell
                    mark.write_bytes(b"flowabs")
                    made.append(mark)
            yield self._seen | {str(mark): len(b"flowabs") for mark in made}
        finally:
            for mark in made:
                with suppress(OSError):
                    mark.unlink()


@contextmanager
def dask_cluster(job: Job, numbers: Sequence[int], options: RunOptions) -> Iterator[DaskCluster]:
    """Connect with the scheduler that ``options`` name, or start workers on this machine.

    Raises
    ------
    CommandError
        no-dask, where Dask is not installed; no-scheduler, where nobody answers; no-worker, where no worker can do
        anything for this run. Nothing has been made then.
    """
    with quiet(), connected_client(options, len(numbers)) as client:
        cluster = DaskCluster(client, job, numbers, options)
        address = "this machine" if cluster.local else str(options.scheduler)
        try:
            warnings = _first_look(cluster)
        except (OSError, TimeoutError) as error:
            raise nobody(str(options.scheduler)) from error
        if not cluster.usable:
            raise _no_worker(cluster, str(options.scheduler))
        threads = sum(place.threads for place in cluster.usable.values())
        count = len(cluster.usable)
        text = f"Dask on {address}: {count} worker{'s' * (count != 1)}, {threads} frame{'s' * (threads != 1)} at once"
        cluster.notes = [Note(text), *warnings]
        yield cluster


def _first_look(cluster: DaskCluster) -> list[Note]:
    """Wait until there is a worker, but not for long, and look at all of them."""
    end = time.monotonic() + dask_connection.CONNECT
    while True:
        stopping.check()
        warnings = stoppable(cluster.look)
        if cluster.places or time.monotonic() > end:
            return warnings
        time.sleep(0.2)


def _version_probe() -> Callable[[], str | None]:
    """Return a function that travels as code, so that workers without the package can be asked for its version."""

    def version() -> str | None:
        try:
            import flowabs_nodes
        except ImportError:
            return None
        return str(flowabs_nodes.__version__)

    return version


def _misfit(version: Any) -> str:
    """Return why a worker with this answer about its version cannot be used, or ""."""
    if version is None:
        return f"has no flowabs-nodes: install {__version__} in its environment"
    if isinstance(version, BaseException):
        return f"cannot be asked for its version of flowabs-nodes: {type(version).__name__}: {version}"
    if version != __version__:
        return f"has flowabs-nodes {version}, and this run is one of {__version__}: both have to be the same"
    return ""


def _no_worker(cluster: DaskCluster, scheduler: str) -> CommandError:
    """Return the error that says why no worker is of any use."""
    if not cluster.places:
        text = f"--scheduler {scheduler}: the scheduler has no workers"
        return CommandError(text, code="no-worker", hint=_START.format(scheduler))
    (address, place), *others = sorted(cluster.places.items())
    more = f", and {len(others)} more of this kind or another" if others else ""
    text = f"--scheduler {scheduler}: no worker can render frames: {address} {place.refused}{more}"
    return CommandError(text, code="no-worker")


def _files_seen(job: Job, numbers: Sequence[int]) -> dict[str, int]:
    """Return the first file of each sequence that is read, with its size, where it is there."""
    values = job.graph.values(1)
    seen = {}
    for name in job.graph.nodes:
        if file_role(job.graph, name) == "input" and numbers:
            with suppress(OSError, ValueError, CommandError):  # not there, or of no use to this run
                path = Files.to_read(file_of(job.graph, name, values[name])).path(numbers[0])
                seen[path] = os.stat(path).st_size
    return seen
