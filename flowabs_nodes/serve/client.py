"""Filter pictures in another process: a client of ``flowabs serve`` in Python.

::

    from flowabs_nodes.serve.client import Client

    with Client() as client:
        plate = client.array((1080, 1920, 4))  # memory that both see: fill it
        comp = client.render("abstraction", {"plate": plate}, ["comp"], set={"line_width": 1.5})["comp"]
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import Cancelled, FlowabsError
from flowabs_nodes.serve.client_link import Link, Listener, ServerDied, connected, started
from flowabs_nodes.serve.client_memory import Memories
from flowabs_nodes.serve.client_pictures import Pixels, shared

__all__ = ["Client", "Pixels", "Rendered", "ServerDied"]


class Rendered(dict[str, npt.NDArray[Any]]):
    """The arrays of a render by output.

    Attributes
    ----------
    seconds
        How long the server took.
    notes
        What it has to tell about the frame: events of docs/running.md.
    said
        How each picture was written: PICTURE of docs/serve.md.
    """

    def __init__(self, arrays: Mapping[str, npt.NDArray[Any]], answer: Mapping[str, Any]) -> None:
        super().__init__(arrays)
        self.seconds: float = answer["seconds"]
        self.notes: list[dict[str, Any]] = answer["notes"]
        self.said: dict[str, dict[str, Any]] = answer["pictures"]


class Client:
    """Starts a server, or connects to one, and has it render. Any threads may use it at once.

    A server of its own that died is started again, and the render that was lost is asked for once more; where it dies
    again, ServerDied is raised.

    Parameters
    ----------
    arguments
        Further words of ``flowabs serve``, such as ``("--cache", "2GB")``.
    log
        Where the server's messages go, as for subprocess.Popen; its stderr is this process's unless given.

    Raises
    ------
    ServerDied
        The server cannot be started.
    """

    def __init__(self, arguments: Sequence[str] = (), *, log: int | IO[bytes] | None = None) -> None:
        self._prepare(lambda: started(arguments, log), own=True)

    @classmethod
    def connect(cls, address: str, token: str) -> Client:
        """Return a client of a server that runs already, by the address and the token that it printed.

        Raises ServerDied where none is there, FlowabsError where the token is wrong or it speaks another protocol.
        """
        client = cls.__new__(cls)
        client._prepare(lambda: connected(address, token), own=False)
        return client

    def _prepare(self, link: Callable[[], Link], *, own: bool) -> None:
        self._make, self._own = link, own
        self._changing = threading.Lock()
        self._at_work: dict[tuple[Link, int], str] = {}  # sessions of the renders at work
        self._closed = False
        self._link = link()
        self._memories = self._new_memories()

    def _new_memories(self) -> Memories:
        link = self._link
        return Memories(lambda words: link.ask(words).words, link.tell)

    # ------------------------------------------------------------------ asking

    def hello(self) -> dict[str, Any]:
        """Return what the server says of itself: flowabs, protocol, pid, threads."""
        return self._plain({"do": "hello"})

    def describe(self, graph: str, set: Mapping[str, Any] | None = None, frame: int = 1) -> dict[str, Any]:
        """Return a graph's knobs, inputs and outputs, for a panel; knobs stand where ``set`` has them, on a frame."""
        return self._plain({"do": "describe", "graph": graph, "set": dict(set or {}), "frame": frame})

    def array(self, shape: tuple[int, ...], dtype: npt.DTypeLike = np.float32) -> npt.NDArray[Any]:
        """Return an array of zeros in memory that the server sees too: pictures in it need not be copied there.

        Once a server has died such an array is one like any other.
        """
        array: npt.NDArray[Any] = self._again(lambda link, memories: memories.array(shape, dtype))
        return array

    def render(
        self,
        graph: str,
        given: Mapping[str, npt.NDArray[Any] | Pixels],
        into: Mapping[str, npt.NDArray[Any] | Pixels] | Iterable[str],
        *,
        set: Mapping[str, Any] | None = None,
        frame: int = 1,
        scale: float = 1.0,
        session: str = "python",
        on_event: Listener | None = None,
    ) -> Rendered:
        """Render one frame.

        Parameters
        ----------
        graph
            The name of a graph that comes with flowabs, or a path.
        given
            Pictures in place of outputs, by "node" or "node.output".
        into
            Outputs, and the arrays to write them to; or their names alone: arrays are made then, (H, W, 4) float32.
        set
            Values of knobs and parameters; all others stand as the graph has them.
        frame, scale
            As :meth:`RunnableGraph.run <flowabs_nodes.engine.runnable.RunnableGraph.run>` takes them.
        session
            A name: renders of the same session compute only what changed, one after the other.
        on_event
            Called with each event of the run (docs/running.md), in this thread.

        Raises
        ------
        Cancelled
            :meth:`cancel` was called.
        ServerDied
            The server died, twice if it is our own.
        FlowabsError
            Whatever went wrong.
        """
        targets = dict(into) if isinstance(into, Mapping) else dict.fromkeys([into] if isinstance(into, str) else into)
        words = {
            "do": "render",
            "session": session,
            "graph": graph,
            "set": dict(set or {}),
            "frame": frame,
            "scale": scale,
            "events": on_event is not None,
        }

        def render(link: Link, memories: Memories) -> Rendered:
            with ExitStack() as borrowed:
                sources = {name: shared(each, memories, borrowed, fill=True)[0] for name, each in given.items()}
                places, back = {}, []
                for name, target in targets.items():
                    places[name], copy = ({}, None) if target is None else shared(target, memories, borrowed)
                    back += [copy] if copy is not None else []
                return self._rendered(link, {**words, "given": sources, "into": places}, targets, back, on_event)

        rendered: Rendered = self._again(render)
        return rendered

    def _rendered(
        self,
        link: Link,
        words: dict[str, Any],
        targets: Mapping[str, npt.NDArray[Any] | Pixels | None],
        back: Iterable[Callable[[], None]],
        on_event: Listener | None,
    ) -> Rendered:
        """Ask for a render whose pictures are described, and return the arrays.

        ``back`` copies those from borrowed memory that lie elsewhere.
        """
        mine: list[tuple[Link, int]] = []

        def numbered(number: int) -> None:
            mine.append((link, number))
            with self._changing:
                self._at_work[link, number] = words["session"]

        try:
            message = link.ask(words, (), on_event, numbered)
        except FlowabsError as error:
            if error.code == Cancelled.code:
                raise Cancelled(error.message) from None
            raise
        finally:
            with self._changing:
                for key in mine:
                    self._at_work.pop(key, None)
        for copy in back:
            copy()
        arrays, start = {}, 0
        for name, said in message.words["pictures"].items():
            target = targets[name]
            if target is not None:
                arrays[name] = target.array if isinstance(target, Pixels) else target
                continue
            shape = said["height"], said["width"], len(said["channels"])
            arrays[name] = np.ndarray(shape, said["dtype"], message.payload, start)
            start += arrays[name].nbytes
        return Rendered(arrays, message.words)

    def cancel(self, session: str | None = None) -> None:
        """Have the renders that are at work, of a session or of all, raise Cancelled; from any thread."""
        with self._changing:
            numbers = [key for key, name in self._at_work.items() if session in (None, name)]
        for link, number in numbers:
            link.tell({"do": "cancel", "of": number})

    def forget(self, session: str) -> None:
        """Let go of a session's pictures and results."""
        self._plain({"do": "forget", "session": session})

    def close(self) -> None:
        """End the connection, and a server of its own."""
        with self._changing:
            self._closed = True
        self._link.close()

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.close()

    # ------------------------------------------------------------------ a server that died

    def _plain(self, words: dict[str, Any]) -> dict[str, Any]:
        answer = self._again(lambda link, memories: link.ask(words)).words
        return {key: value for key, value in answer.items() if key not in ("id", "ok")}

    def _again(self, work: Callable[[Link, Memories], Any]) -> Any:
        """Do some work with the server; where it dies, once more with a new one."""
        link, memories = self._living()
        try:
            return work(link, memories)
        except ServerDied:
            if not self._own or self._closed:
                raise
            return work(*self._living(instead_of=link))

    def _living(self, instead_of: Link | None = None) -> tuple[Link, Memories]:
        """Return the connection and its memory; new ones where the server is known to have died."""
        with self._changing:
            if self._own and not self._closed and (self._link is instead_of or not self._link.alive):
                self._link.close()
                self._link = self._make()
                self._memories = self._new_memories()
            return self._link, self._memories
