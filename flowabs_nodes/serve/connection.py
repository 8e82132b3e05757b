"""One client: its requests are read and answered, renders go on beside, until it leaves."""

from __future__ import annotations

import os
import queue
import threading
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.serve import describing, shared_memory
from flowabs_nodes.serve.fields import Fields
from flowabs_nodes.serve.framing import (
    BadMessage,
    Buffer,
    ByteStream,
    Message,
    check_protocol,
    greeting,
    packed,
    read_message,
    write_message,
)
from flowabs_nodes.serve.rendering import Render, failure
from flowabs_nodes.serve.sessions import Sessions
from flowabs_nodes.serve.shared_memory import SharedMemory
from flowabs_nodes.simd.bands import available_threads

_MOST_RENDERS = 64  # of one client, at work or waiting
_MOST_MEMORIES = 256
_MOST_UNREAD = 4096  # messages that a client may leave unread
_LAST_WORDS = 0.3  # seconds that the last answers may take to be read


class Outbox:
    """Writes messages to a client in a thread of its own, so that a client that reads slowly holds up nobody.

    ``lost`` is called once where the client reads no more.
    """

    def __init__(self, stream: ByteStream, lost: Callable[[], None]) -> None:
        self._stream, self._lost = stream, lost
        self._waiting: queue.Queue[list[memoryview] | None] = queue.Queue(_MOST_UNREAD)
        self._writer = threading.Thread(target=self._write, name="flowabs-outbox", daemon=True)
        self._writer.start()

    def send(self, words: dict[str, Any], payload: Iterable[Buffer] = ()) -> None:
        """Have a message written."""
        try:
            self._waiting.put_nowait(packed(words, payload))
        except queue.Full:
            self._lost()

    def close(self) -> None:
        """Wait a moment for the last messages to be written."""
        with suppress(queue.Full):
            self._waiting.put_nowait(None)
            self._writer.join(_LAST_WORDS)

    def _write(self) -> None:
        with suppress(OSError, ValueError):  # ValueError: the stream is closed
            while (parts := self._waiting.get()) is not None:
                write_message(self._stream, parts)
            return
        self._lost()


class Connection:
    """Serves one client.

    Parameters
    ----------
    number
        A number of its own.
    stream
        Where messages come from.
    outbox
        Where answers go to.
    sessions
        Those of all clients.
    max_pixels
        The most pixels that a picture may have.
    stop
        Ends the server.
    """

    def __init__(
        self,
        number: int,
        stream: ByteStream,
        outbox: Outbox,
        sessions: Sessions,
        max_pixels: int,
        stop: Callable[[], None],
    ) -> None:
        self._number, self._stream, self._outbox = number, stream, outbox
        self._sessions, self._max_pixels, self._stop = sessions, max_pixels, stop
        self._memories: dict[int, SharedMemory] = {}
        self._renders: dict[int, Render] = {}
        self._changing = threading.Lock()
        self._requests: dict[str, Callable[[int, Message], dict[str, Any] | None]] = {
            "hello": self._hello,
            "describe": self._describe,
            "map": self._map,
            "unmap": self._unmap,
            "render": self._render,
            "cancel": self._cancel,
            "forget": self._forget,
            "stop": lambda number, message: {},
        }

    def serve(self) -> BadMessage | None:
        """Greet the client and answer its requests until it leaves; return what it said last that was no message."""
        self._outbox.send(greeting())
        try:
            while (message := read_message(self._stream, shared_memory.most_bytes(self._max_pixels))) is not None:
                self._hear(message)
                if message.words.get("do") == "stop":
                    self._outbox.close()
                    self._stop()
                    break
        except (BadMessage, MemoryError) as error:
            no_room = BadMessage("not enough memory for the payload", code="out-of-memory")
            bad = error if isinstance(error, BadMessage) else no_room
            self._outbox.send({"id": None, **failure(bad)})
            return bad
        except OSError:  # the client is gone
            pass
        finally:
            self.close()
        return None

    def close(self) -> None:
        """Cancel the client's renders, and let go of its sessions and of its memory."""
        with self._changing:
            renders = tuple(self._renders.values())
        for render in renders:
            render.cancel()
        self._sessions.forget(self._number)
        self._memories.clear()

    def _hear(self, message: Message) -> None:
        """Answer a request, or begin to."""
        number = message.words.get("id")
        try:
            if type(number) is not int:
                raise CommandError(f"id: expected a whole number, found {number!r}"[:200], code="bad-request")
            do = Fields(message.words, "", message.words).word("do", self._requests)
            with error_boundary():
                answer = self._requests[do](number, message)
        except FlowabsError as error:
            answer = failure(error)
        if answer is not None:
            self._outbox.send({"id": number if type(number) is int else None, "ok": True, **answer})

    # ------------------------------------------------------------------ requests

    def _hello(self, number: int, message: Message) -> dict[str, Any]:
        _fields(message, "protocol")
        check_protocol(message.words, "client")
        return {**greeting(), "pid": os.getpid(), "threads": available_threads()}

    def _describe(self, number: int, message: Message) -> None:
        asked = _fields(message, "graph", "set", "frame")
        source, values, frame = asked.get("graph", str), asked.get("set", dict, {}), asked.get("frame", int, 1)

        def describe() -> None:
            """Describe the graph beside: the first one imports all nodes."""
            try:
                with error_boundary():
                    answer = {"ok": True, **describing.described(source, values, frame)}
            except FlowabsError as error:
                answer = failure(error)
            self._outbox.send({"id": number, **answer})

        threading.Thread(target=describe, name="flowabs-describe", daemon=True).start()

    def _map(self, number: int, message: Message) -> dict[str, Any]:
        asked = _fields(message, "memory", "path", "name", "bytes")
        memory = asked.get("memory", int)
        bytes_ = asked.count("bytes", 1, shared_memory.most_bytes(self._max_pixels))
        if memory in self._memories:
            raise CommandError(f"memory: {memory} is mapped already", code="bad-request", parameter="memory")
        if len(self._memories) >= _MOST_MEMORIES:
            raise CommandError(f"memory: {_MOST_MEMORIES} are mapped already", code="too-many", parameter="memory")
        name = asked.get("name", str, "")
        self._memories[memory] = (
            shared_memory.opened_name(name, bytes_)
            if name
            else shared_memory.opened_file(asked.get("path", str), bytes_)
        )
        return {}

    def _unmap(self, number: int, message: Message) -> dict[str, Any]:
        memory = _fields(message, "memory").get("memory", int)
        if self._memories.pop(memory, None) is None:
            raise CommandError(f"memory: no memory {memory} is mapped", code="unknown-memory", parameter="memory")
        return {}

    def _render(self, number: int, message: Message) -> None:
        render = Render(number, message.words, message.payload, self._memories, self._number, self._max_pixels)
        with self._changing:
            if number in self._renders:
                raise CommandError(f"id: {number} is at work already", code="bad-request", parameter="id")
            if len(self._renders) >= _MOST_RENDERS:
                raise CommandError(f"{_MOST_RENDERS} renders are at work or waiting already", code="too-many")
            self._renders[number] = render

        def ended() -> None:
            with self._changing:
                del self._renders[number]

        render.start(self._sessions, self._outbox.send, ended)

    def _cancel(self, number: int, message: Message) -> dict[str, Any]:
        of = _fields(message, "of").get("of", int)
        with self._changing:
            render = self._renders.get(of)
        if render is not None:  # else it has ended
            render.cancel()
        return {}

    def _forget(self, number: int, message: Message) -> dict[str, Any]:
        self._sessions.forget(self._number, _fields(message, "session").get("session", str))
        return {}


def _fields(message: Message, *known: str) -> Fields:
    """Return a request's values, with these keys beside those of every request."""
    return Fields(message.words, "", ("id", "do", "payload", *known))
