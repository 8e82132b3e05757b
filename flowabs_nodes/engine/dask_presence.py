"""Watches, during a run, whether Dask's scheduler answers and whether a worker is there."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from flowabs_nodes.engine.dask_cluster import DaskCluster
from flowabs_nodes.engine.dask_worker import TOPIC
from flowabs_nodes.engine.report import Note

_NEWS = 2.0  # seconds between two looks at which workers there are

#: Seconds that a run waits for a worker where there is none any more: those of a cloud take minutes to come.
ALONE = 300.0


class DaskPresence:
    """Says whether a run can go on: :attr:`connected`, and :meth:`lost` once it cannot for good.

    ``hear`` takes the workers' messages: it is subscribed again when a connection that was lost is there again.
    """

    def __init__(self, cluster: DaskCluster, tell: Callable[[Note], None], hear: Callable[[Any], None]) -> None:
        self._cluster = cluster
        self._tell = tell
        self._hear = hear
        self._alone_since: float | None = None
        self._news: list[Note] = []  # of the thread that looks at the workers
        self.connected = True

    def watch(self, over: threading.Event) -> None:
        """Subscribe, and find out every few seconds which workers there are, until ``over``.

        A thread of its own does it, for a scheduler may take its time.
        """
        threading.Thread(target=self._look, args=(over,), name="flowabs-dask", daemon=True).start()
        self._cluster.client.subscribe_topic(TOPIC, self._hear)

    def tell_news(self) -> None:
        """Tell of the workers that have come and gone."""
        while self._news:
            self._tell(self._news.pop(0))

    def lost(self) -> tuple[str, str] | None:
        """Return why the run cannot go on, and the code of that error; None where it can, or may be able to again."""
        client = self._cluster.client
        if client.status != "running":
            if self.connected:
                self.connected = False
                self._tell(Note("the connection with Dask's scheduler is lost: trying to connect", warning=True))
            return None if client.status == "connecting" else ("Dask's scheduler is gone", "scheduler-lost")
        if not self.connected:
            self.connected = True
            client.subscribe_topic(TOPIC, self._hear)
        if self._cluster.usable:
            self._alone_since = None
        elif self._alone_since is None:
            self._alone_since = time.monotonic()
            self._tell(Note(f"no worker is left: waiting up to {ALONE:g} s for one", warning=True))
        elif time.monotonic() - self._alone_since > ALONE:
            return f"no worker of Dask for {ALONE:g} s", "no-worker"
        return None

    def _look(self, over: threading.Event) -> None:
        while not over.wait(_NEWS):
            with suppress(Exception):  # the scheduler does not answer: the client notices
                self._news += self._cluster.look()
