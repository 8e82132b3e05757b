"""What a session holds between its runs, and how a run makes use of it."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

from flowabs_nodes import stopping
from flowabs_nodes.engine.compiler import load_compiler
from flowabs_nodes.engine.frame_outputs import FrameOutputs
from flowabs_nodes.engine.node_events import NodeEvents
from flowabs_nodes.engine.plan import Result
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.engine.result_store import ResultStore, StoredKey
from flowabs_nodes.engine.stopwatch import Stopwatch

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.engine.report import Listener, Note
    from flowabs_nodes.engine.runnable import RunnableGraph
    from flowabs_nodes.image import Image

_PATIENCE = 0.02  # seconds between two looks at whether a run that waits for its turn was cancelled


class SessionCache:
    """Holds results by what they were made from, in at most ``max_bytes``."""

    def __init__(self, max_bytes: int) -> None:
        self.store = ResultStore(max_bytes, keeps_all=True)
        self._names: WeakKeyDictionary[Image, str] = WeakKeyDictionary()
        self._count = itertools.count(1)
        self._at_work = threading.Lock()
        self._told = _Told()
        self._types: dict[str, str] = {}  # of the nodes of the graph at work, by name
        self._nodes = NodeEvents(self._told.tell, self._types)  # knows from run to run what each costs

    def compute(
        self,
        graph: RunnableGraph,
        frame: int,
        names: tuple[str, ...],
        given: Mapping[Result, Image],
        options: RunOptions,
        notes: list[Note],
        tell: Listener | None,
        scaled: bool = False,
    ) -> dict[str, Image]:
        """Return the outputs ``names`` of a frame; what is held is not computed again.

        ``notes`` fills up; ``tell`` is told which node is at work. ``scaled``: what is given is as small already as the
        options say. Runs take turns.

        Raises
        ------
        FlowabsError
            Whatever went wrong.
        Stopped
            The work was asked to stop, at work or while it waited.
        """
        with self._turn():
            load_compiler()
            self._told.listener = tell or _nobody
            by = 1.0 if scaled else options.scale
            keys = {result: self._name(image, by) for result, image in given.items()}
            images = {result: self._scaled(image, by) for result, image in given.items()}
            work = FrameOutputs(graph, frame, names, images, options)
            unit_keys = work.keys(keys)
            stored = {
                result: StoredKey(unit_keys[result.unit], result.output, result.frame)
                for step in work.steps
                for result in step.makes
            }
            held = {result: self.store.get(key) for result, key in stored.items()}
            work.leave_out({result: image for result, image in held.items() if image is not None})
            self._types.clear()
            self._types.update({name: node.declaration.type for name, node in graph.nodes.items()})
            self._nodes.begin_frame(frame)
            self._nodes.plan(work.steps)

            def keep(result: Result, image: Image) -> None:
                self.store.put(stored[result], image)

            return work.compute(notes, Stopwatch(self._nodes if tell else None), keep)

    @contextmanager
    def _turn(self) -> Iterator[None]:
        """Wait until no other run is at work, or until this one is asked to stop."""
        while not self._at_work.acquire(timeout=_PATIENCE):
            stopping.check()
        try:
            yield
        finally:
            self._at_work.release()

    def _name(self, image: Image, scale: float) -> str:
        """Return the key of an image that comes from outside, as long as it exists, at the scale of a run."""
        return f"{self._names.setdefault(image, f'given {next(self._count)}')} at {scale!r}"

    def _scaled(self, image: Image, scale: float) -> Image:
        """Return an image that comes from outside at the scale of a run, made once."""
        key = StoredKey(self._name(image, scale), "", 0)
        found = image if scale == 1 else self.store.get(key)
        if found is None:
            found = scale_image(image, scale)
            self.store.put(key, found)
        return found


class _Told:
    """Hands events to the listener of the run at work: apart from the cache, which so goes with its last user."""

    def __init__(self) -> None:
        self.listener: Listener = _nobody

    def tell(self, event: dict[str, Any]) -> None:
        self.listener(event)


def _nobody(event: object) -> None:
    """Hear an event that nobody asked for."""
