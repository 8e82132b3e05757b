"""A graph held open under a host: what a change does not touch is not computed again, and a run can be cancelled."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from types import TracebackType
from typing import Any

from flowabs_nodes.engine.frame_numbers import frame_number
from flowabs_nodes.engine.given import Given, given_images, same_image
from flowabs_nodes.engine.knob_states import KnobState, knob_states
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.plan import named_result, output_names
from flowabs_nodes.engine.plate_file import with_plate_file
from flowabs_nodes.engine.report import Listener, Note, tell_notes
from flowabs_nodes.engine.runnable import GraphSource, RunnableGraph, load_graph
from flowabs_nodes.engine.session_cache import SessionCache
from flowabs_nodes.engine.stoppable_call import StoppableCall
from flowabs_nodes.errors import CommandError
from flowabs_nodes.image import Image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.simd.bands import limited

#: The most bytes of results that a session holds, unless it is told another number.
CACHE_BYTES = 2**30


class Session:
    """Holds a graph, the pictures given to it, and the results of its runs.

    ::

        with fa.Session("abstraction") as session:
            session.given(plate=image)
            session.set(line_width=1.5)
            drawn = session.run("comp", scale=0.5)["comp"]

    A run computes only what changed since any earlier one: results are known by what they were made from, and those
    used longest ago are dropped first. Any number of sessions may run at once, each in a thread of its own; runs of one
    session take turns. What is set while a run is at work is for the next.

    Parameters
    ----------
    graph
        A path, the name of a graph that comes with the package, its content as a dict, or one that is loaded.
    cache_bytes
        The most bytes of results to hold. Beside them a session holds the pictures that it was given.
    threads
        How many threads a filter uses; None: as many as there are processors.
    settings
        How pictures are read: the largest size, the OCIO config, the folder that may be touched.
    on_event
        Called with a dict for each node that begins or ends and for each note (docs/running.md describes them), in the
        thread that called :meth:`run`. Without it notes go to the logger "flowabs".

    Raises
    ------
    GraphError
        With every problem of the graph in ``problems``.
    CommandError
        The graph's file cannot be read, or there is no graph of that name.
    """

    def __init__(
        self,
        graph: GraphSource,
        *,
        cache_bytes: int = CACHE_BYTES,
        threads: int | None = None,
        settings: Settings | None = None,
        on_event: Listener | None = None,
    ) -> None:
        self._loaded = self._graph = load_graph(graph)
        self._values: dict[str, Any] = {}
        self._given: dict[str, Image | dict[int, Image]] = {}
        self._threads, self._settings, self._on_event = threads, settings or Settings(), on_event
        self._cache = SessionCache(cache_bytes)
        self._changing = threading.Lock()
        self._calls: set[StoppableCall[dict[str, Image]]] = set()
        self._closed = False

    # ------------------------------------------------------------------ what it stands at

    @property
    def graph(self) -> RunnableGraph:
        """Return the graph with all that has been set."""
        return self._graph

    @property
    def cached_bytes(self) -> int:
        """Return how many bytes of results are held."""
        return self._cache.store.bytes

    def knobs(self, frame: int = 1) -> tuple[KnobState, ...]:
        """Return every knob as a panel shows it, with its value on a frame, and whether it does anything there."""
        return knob_states(self._loaded, self._graph, frame_number(frame))

    def set(self, values: Mapping[str, Any] | None = None, /, **knobs: Any) -> None:
        """Set knobs and parameters: ``set(line_width=1.5)``, ``set({"lines.softness": 2})``. They stay until set again.

        Raises
        ------
        GraphError
            With every wrong name and value; nothing is set then.
        """
        with self._changing:
            self._set({**self._values, **(values or {}), **knobs})

    def reset(self, *names: str) -> None:
        """Set these knobs and parameters back to what the graph says; all of them without names."""
        with self._changing:
            self._set({name: value for name, value in self._values.items() if names and name not in names})

    def exchange(self, graph: GraphSource) -> None:
        """Have another graph in place of this one, such as the same one after an edit.

        What both compute in the same way is not computed again. All that was set is forgotten; pictures that were given
        stay under the names that the new graph has.

        Raises
        ------
        GraphError, CommandError
            As the constructor; the session keeps its graph then.
        """
        loaded = load_graph(graph)
        with self._changing:
            self._loaded = self._graph = loaded
            self._values = {}
            self._given = {name: what for name, what in self._given.items() if _has_output(loaded, name)}

    def _set(self, values: dict[str, Any]) -> None:
        """Have just these values set."""
        self._graph, self._values = self._loaded.with_set(values), values

    def given(self, pictures: Given | None = None, /, **more: Any) -> None:
        """Give pictures in place of outputs, as in :meth:`RunnableGraph.run`: ``given(plate=image)``.

        They stay until others are given under their names; None takes one away. A picture that equals the one it
        replaces, bit for bit, changes nothing: a host may hand over its plate anew with every turn of a knob.

        Raises
        ------
        CommandError
            A name is no output of the graph.
        ArgumentError
            Something given is no image of the output's type.
        """
        accepted: dict[str, Image | dict[int, Image] | None] = {}
        for name, what in {**(pictures or {}), **more}.items():
            if what is None:
                named_result(self._loaded, name, 1)
                accepted[name] = None
            elif isinstance(what, Mapping):
                images = given_images(self._loaded, {name: what}, next(iter(what), 1))
                accepted[name] = {result.frame: image for result, image in images.items()}
            else:
                (accepted[name],) = given_images(self._loaded, {name: what}, 1).values()
        with self._changing:
            for name, what in accepted.items():
                before = self._given.pop(name, None)
                if what is not None:
                    self._given[name] = _unless_same(what, before)

    # ------------------------------------------------------------------ running

    def run(
        self,
        outputs: str | Iterable[str] | None = None,
        frame: int = 1,
        scale: float = 1.0,
        *,
        scaled: bool = False,
    ) -> dict[str, Image]:
        """Compute images of one frame; ``outputs``, ``frame`` and ``scale`` are those of :meth:`RunnableGraph.run`.

        ``scaled``: the pictures given are so much smaller already, as a host's proxies are. They stay as they are, and
        lengths follow ``scale``.

        Returns
        -------
        dict
            An Image for each name in ``outputs``.

        Raises
        ------
        Cancelled
            :meth:`cancel` was called; it is raised within milliseconds, whatever is at work. A filter then stops
            soon; a library's call goes on in the background, and its result is dropped.
        FlowabsError
            Whatever :meth:`RunnableGraph.run` raises.
        """
        frame = frame_number(frame)
        options, about_colors = choose_config(RunOptions(scale=scale, **vars(self._settings)))
        notes: list[Note] = list(about_colors)
        with self._changing:
            if self._closed:
                raise CommandError("the session is closed", code="closed")
            graph, names = load_graph(with_plate_file(self._graph)), output_names(self._graph, outputs)
            given = given_images(graph, self._given, frame)

        def work() -> dict[str, Image]:
            with limited(self._threads) if self._threads else nullcontext():
                return self._cache.compute(graph, frame, names, given, options, notes, tell, scaled)

        call = StoppableCall(work, self._on_event or (lambda event: None))
        tell = call.tell if self._on_event else None
        with self._changing:
            self._calls.add(call)
        try:
            return call.result()
        finally:
            with self._changing:
                self._calls.discard(call)
            tell_notes(tuple(notes), frame, self._on_event)

    def cancel(self) -> None:
        """Have every run of this session that is at work or waits for its turn raise Cancelled; from any thread."""
        with self._changing:
            calls = tuple(self._calls)
        for call in calls:
            call.cancel()

    def close(self) -> None:
        """Cancel what is at work and let go of all pictures and results. Any further run raises CommandError."""
        with self._changing:
            self._closed = True
            self._given.clear()
            self._cache = SessionCache(0)  # what is still at work has the old one
        self.cancel()

    def __enter__(self) -> Session:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()


def _has_output(graph: RunnableGraph, name: str) -> bool:
    """Return whether a graph has an output of this name."""
    try:
        named_result(graph, name, 1)
    except CommandError:
        return False
    return True


def _unless_same(what: Image | dict[int, Image], before: Image | dict[int, Image] | None) -> Any:
    """Return what is given now, with the images of ``before`` in place of those that are the same."""
    if isinstance(what, dict):
        others = before if isinstance(before, dict) else {}
        return {frame: _unless_same(image, others.get(frame)) for frame, image in what.items()}
    return before if isinstance(before, Image) and same_image(what, before) else what
