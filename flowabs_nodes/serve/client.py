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
from dataclasses import dataclass
from types import TracebackType
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import ArgumentError, Cancelled, FlowabsError
from flowabs_nodes.serve.client_link import Link, Listener, ServerDied, connected, started
from flowabs_nodes.serve.client_memory import Memories, Place

__all__ = ["Client", "Pixels", "Rendered", "ServerDied"]

_CHANNELS = {1: "A", 3: "RGB", 4: "RGBA"}


@dataclass(frozen=True, eq=False)
class Pixels:
    """An array of a picture, and what it means.

    Attributes
    ----------
    array
        (H, W, C) float32, float16, uint8 or uint16 with channels R, G, B[, A], or (H, W) of one alone, a mask.
    colorspace
        The name of its scene-linear space or encoding, as ``flowabs colorspaces`` lists them.
    alpha
        "premultiplied", "straight", or "opaque": its fourth channel means nothing.
    rows
        "top-down", or "bottom-up" where the first row is the lowest.
    window
        x, y of the first pixel in the full picture, y down.
    display
        (x, y, width, height) of the full picture; None: that of the pixels.
    """

    array: npt.NDArray[Any]
    colorspace: str = "lin_rec709"
    alpha: str = "premultiplied"
    rows: str = "top-down"
    window: tuple[int, int] = (0, 0)
    display: tuple[int, int, int, int] | None = None


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
                sources = {name: _shared(each, memories, borrowed, fill=True)[0] for name, each in given.items()}
                places, back = {}, []
                for name, target in targets.items():
                    places[name], copy = ({}, None) if target is None else _shared(target, memories, borrowed)
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


def _shared(
    picture: npt.NDArray[Any] | Pixels, memories: Memories, borrowed: ExitStack, *, fill: bool = False
) -> tuple[dict[str, Any], Callable[[], None] | None]:
    """Return a picture as a request says it, and what copies it back from memory that had to be borrowed.

    With ``fill`` the borrowed memory holds what the array does.
    """
    pixels = picture if isinstance(picture, Pixels) else Pixels(picture)
    array = pixels.array
    if not isinstance(array, np.ndarray) or array.ndim not in (2, 3) or array.size == 0:
        found = f"{array.dtype} {array.shape}" if isinstance(array, np.ndarray) else type(array).__name__
        raise ArgumentError(f"picture: expected an array (H, W) or (H, W, C), found {found}", parameter="picture")
    array = array if array.ndim == 3 else array[..., None]
    height, width, count = array.shape
    if count not in _CHANNELS:
        raise ArgumentError(f"picture: expected 1, 3 or 4 channels, found {count}", parameter="picture")
    place = memories.place(array) if array.strides[1:] == (count * array.itemsize, array.itemsize) else None
    copy = None
    if place is None:
        number, bytes_ = borrowed.enter_context(memories.borrowed(array.nbytes))
        there = np.ndarray(array.shape, array.dtype, bytes_)
        if fill:
            np.copyto(there, array)
        else:
            copy = _copy(array, there)
        place, row_bytes = Place(number, 0), there.strides[0]
    else:
        row_bytes = array.strides[0]
    words = {
        **place._asdict(),
        "width": width,
        "height": height,
        "channels": _CHANNELS[count],
        "dtype": array.dtype.name,
        "row_bytes": row_bytes,
        "rows": pixels.rows,
        "colorspace": pixels.colorspace,
        "alpha": pixels.alpha,
        "window": list(pixels.window),
        "display": None if pixels.display is None else list(pixels.display),
    }
    return words, copy


def _copy(array: npt.NDArray[Any], there: npt.NDArray[Any]) -> Callable[[], None]:
    """Return a function that copies ``there`` to ``array``."""
    return lambda: np.copyto(array, there)
