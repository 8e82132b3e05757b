"""A render: what a client asks for, and doing it, in a thread of its own."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.plan import named_result
from flowabs_nodes.errors import Cancelled, CommandError, FlowabsError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.serve.fields import Fields
from flowabs_nodes.serve.framing import Buffer
from flowabs_nodes.serve.pictures import Picture, picture
from flowabs_nodes.serve.sessions import HeldSession, Sessions
from flowabs_nodes.serve.shared_memory import SharedMemory
from flowabs_nodes.stopping import StopFlag, Stopped, stopped_by

KEYS = ("id", "do", "payload", "session", "graph", "set", "given", "into", "frame", "scale", "events")

#: Sends an object of JSON to the client, with bytes behind it.
Send = Callable[..., None]
Payload = npt.NDArray[np.uint8]

Made = TypeVar("Made")


class Render:
    """One request to render.

    Raises CommandError, when it is made, for a request that is wrong.

    Parameters
    ----------
    number
        What the client calls it.
    words, payload
        The request.
    memories
        The memory that the client has shared. The pictures keep what they lie in.
    client
        The number of the client's connection.
    max_pixels
        The most pixels that a picture may have.
    """

    def __init__(
        self,
        number: int,
        words: dict[str, Any],
        payload: Payload,
        memories: Mapping[int, SharedMemory],
        client: int,
        max_pixels: int,
    ) -> None:
        asked = Fields(words, "", KEYS)
        self.number = number
        self._name = client, asked.get("session", str)
        self._graph = asked.get("graph", str)
        self._values = asked.get("set", dict, {})
        self._frame = asked.get("frame", int, 1)
        self._scale = asked.get("scale", float, 1.0)
        self._events = asked.get("events", bool, False)
        self._given = {
            name: picture(each, f"given.{name}", memories, max_pixels)
            for name, each in asked.get("given", dict, {}).items()
        }
        self._into = {
            name: picture(each, f"into.{name}", memories, max_pixels, sized=False)
            for name, each in asked.get("into", dict).items()
        }
        if not self._into:
            raise CommandError("into: expected at least one output, found none", code="bad-request", parameter="into")
        self._payloads = _payloads(self._given, payload)
        self._flag = StopFlag()
        self._held: HeldSession | None = None

    def start(self, sessions: Sessions, send: Send, ended: Callable[[], None]) -> None:
        """Render in a thread; ``ended`` is called before the answer is sent."""

        def run() -> None:
            answer, payload = self._answer(sessions, send)
            ended()
            send({"id": self.number, **answer}, payload)

        threading.Thread(target=run, name="flowabs-render", daemon=True).start()

    def cancel(self) -> None:
        """Have it end at once, with the error "cancelled"; any thread may call this, at any time."""
        self._flag.set()
        held = self._held
        if held is not None:
            held.cancel(self._flag)

    def _answer(self, sessions: Sessions, send: Send) -> tuple[dict[str, Any], list[Buffer]]:
        """Return the answer, and the bytes that go with it."""
        begun = time.perf_counter()
        notes: list[dict[str, Any]] = []

        def tell(event: dict[str, Any]) -> None:
            if event["event"] == "note":
                notes.append(event)
            if self._events:
                send({"id": self.number, "event": event})

        try:
            with stopped_by(self._flag), error_boundary(), sessions.using(self._name) as held:
                self._held = held
                with held.turn(self._flag, tell), sessions.at_work():
                    pictures, payload = self._render(held)
        except Stopped:
            return failure(Cancelled("cancelled")), []
        except FlowabsError as error:
            if error.code == "closed":  # the client forgot the session, or left
                error = Cancelled("cancelled: the session was let go")
            return {**failure(error), "notes": notes}, []
        seconds = round(time.perf_counter() - begun, 4)
        return {"ok": True, "seconds": seconds, "notes": notes, "pictures": pictures}, payload

    def _render(self, held: HeldSession) -> tuple[dict[str, Any], list[Buffer]]:
        """Return what was written of each output, and the bytes to send."""
        session = held.ready(self._graph, self._values)
        given = {}
        for name, each in self._given.items():
            result = named_result(session.graph, name, self._frame)
            port = session.graph.nodes[result.node].declaration.all_outputs[result.output]
            given[name] = _at(f"given.{name}", each.image, port.types, self._payloads.get(name))
        held.give(session, given)
        images = session.run(list(self._into), self._frame, self._scale)
        written, payload = {}, list[Buffer]()
        for name, target in self._into.items():
            written[name], bytes_ = _at(f"into.{name}", target.fill, images[name])
            if bytes_ is not None:
                written[name]["offset"] = 0
                payload.append(bytes_)
        return written, payload


def failure(error: FlowabsError) -> dict[str, Any]:
    """Return the answer that tells an error; of a graph's problems the message tells the first."""
    told = error.to_dict()
    if isinstance(error, GraphError):
        first = next((each for each in error.problems if not each.warning), None)
        told["message"] += f": {first}" if first is not None else ""
    return {"ok": False, "error": told}


def _at(place: str, work: Callable[..., Made], *arguments: Any) -> Made:
    """Do some work with a picture; an error says which picture it is."""
    try:
        return work(*arguments)
    except FlowabsError as error:
        message = error.message.removeprefix(f"{error.parameter}: ").removeprefix("picture: ")
        error.message, error.parameter = f"{place}: {message}", place
        raise


def _payloads(given: Mapping[str, Picture], payload: Payload) -> dict[str, Payload]:
    """Return the bytes of each picture that came with the message. Raises CommandError where they do not fit."""
    start, found = 0, {}
    for name, each in given.items():
        if each.memory is None:
            found[name] = payload[start : start + each.payload_bytes]
            start += each.payload_bytes
    if start != len(payload):
        raise CommandError(
            f"payload: expected {start} bytes for the pictures in it, found {len(payload)}",
            code="bad-request",
            parameter="payload",
        )
    return found
