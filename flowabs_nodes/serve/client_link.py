"""A connection to a server, of its own process or over a socket: requests go out, answers come to who asked."""

from __future__ import annotations

import itertools
import queue
import socket
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from typing import IO, Any

from flowabs_nodes.engine import child_python
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.serve.framing import (
    PROTOCOL,
    BadMessage,
    Buffer,
    ByteStream,
    Message,
    check_protocol,
    packed,
    read_message,
    write_message,
)

_MOST_PAYLOAD = 2**40
_PATIENCE = 5.0  # seconds that a server may take to end

Listener = Callable[[dict[str, Any]], None]


class ServerDied(FlowabsError):
    """The server has ended, or cannot be started or reached; what was asked of it is lost."""

    code = "server-died"


class Link:
    """A connection. ``reads`` and ``writes`` are its streams, ``close`` lets go of them and of the server."""

    def __init__(self, reads: ByteStream, writes: ByteStream, close: Callable[[], None]) -> None:
        self._writes, self._close = writes, close
        self._numbers = itertools.count(1)
        self._waiting: dict[int, queue.SimpleQueue[Message | None]] = {}
        self._sending, self._changing = threading.Lock(), threading.Lock()
        self._ended = ""
        try:
            self.greeting = _first_words(reads)
        except FlowabsError:
            close()
            raise
        threading.Thread(target=self._read, args=(reads,), name="flowabs-answers", daemon=True).start()

    @property
    def alive(self) -> bool:
        """Return whether the server has not been seen to end."""
        return not self._ended

    def ask(
        self,
        words: dict[str, Any],
        payload: Iterable[Buffer] = (),
        on_event: Listener | None = None,
        on_number: Callable[[int], None] | None = None,
    ) -> Message:
        """Send a request and return its answer; ``on_number`` is told the request's number before.

        Raises
        ------
        FlowabsError
            What the server answers; ServerDied where it ends before it does.
        """
        number, answers = next(self._numbers), queue.SimpleQueue[Message | None]()
        with self._changing:
            if self._ended:
                raise ServerDied(self._ended)
            self._waiting[number] = answers
        try:
            if on_number is not None:
                on_number(number)
            self._send({"id": number, **words}, payload)
            while (message := answers.get()) is not None:
                if "event" not in message.words:
                    return _checked(message)
                if on_event is not None:
                    on_event(message.words["event"])
            raise ServerDied(self._ended)
        finally:
            with self._changing:
                self._waiting.pop(number, None)

    def tell(self, words: dict[str, Any]) -> None:
        """Send a request whose answer nobody waits for; where the server has ended, nothing happens."""
        with suppress(ServerDied):
            self._send({"id": next(self._numbers), **words}, ())

    def close(self) -> None:
        """End the connection; a server of ours ends with it."""
        self._close()

    def _send(self, words: dict[str, Any], payload: Iterable[Buffer]) -> None:
        try:
            with self._sending:
                write_message(self._writes, packed(words, payload))
        except (OSError, ValueError) as error:  # ValueError: the stream is closed
            raise ServerDied(f"the server has ended: {error}") from None

    def _read(self, reads: ByteStream) -> None:
        """Hand each message to who waits for it, until there are no more."""
        why = "the server has ended"
        try:
            while (message := read_message(reads, _MOST_PAYLOAD)) is not None:
                number = message.words.get("id")
                if number is None and "error" in message.words:
                    why = f"the server ended the connection: {message.words['error'].get('message')}"
                with self._changing:
                    answers = self._waiting.get(number) if isinstance(number, int) else None
                if answers is not None:
                    answers.put(message)
        except (OSError, ValueError, BadMessage) as error:
            why = f"{why}: {error}"
        with self._changing:
            self._ended = why
            waiting = tuple(self._waiting.values())
        for answers in waiting:
            answers.put(None)


def started(arguments: Sequence[str], log: int | IO[bytes] | None) -> Link:
    """Start ``flowabs serve`` and return the connection to it; its log goes to ``log``, stderr unless it is given.

    Raises ServerDied where it cannot be started.
    """
    try:
        process = child_python.start(
            "flowabs_nodes.__main__",
            "serve",
            *arguments,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            bufsize=0,
        )
    except OSError as error:
        raise ServerDied(f"the server cannot be started: {error.strerror or error}") from None
    reads: Any = process.stdout
    writes: Any = process.stdin

    def close() -> None:
        with suppress(OSError):
            writes.close()  # the server ends
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    return Link(reads, writes, close)


def connected(address: str, token: str) -> Link:
    """Return a connection to a server that listens at ``address``, as it printed it. ServerDied where none does."""
    host, colon, port = address.rpartition(":")
    local = bool(colon) and port.isdecimal() and "/" not in address
    try:
        client = socket.create_connection((host, int(port))) if local else socket.socket(socket.AF_UNIX)
        if local:
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        else:
            client.connect(address)
    except OSError as error:
        raise ServerDied(f"no server listens at {address}: {error.strerror or error}") from None
    stream: Any = socket.SocketIO(client, "rwb")

    def close() -> None:
        with suppress(OSError):
            client.shutdown(socket.SHUT_RDWR)
        client.close()

    with suppress(OSError):
        write_message(stream, packed({"token": token, "protocol": PROTOCOL}))
    return Link(stream, stream, close)


def _first_words(reads: ByteStream) -> dict[str, Any]:
    """Return how the server greets. Raises what it says instead, or ServerDied where it says nothing."""
    try:
        message = read_message(reads, 0)
    except OSError:
        message = None
    if message is None:
        raise ServerDied("the server ended before it said a word", hint="its log says why")
    words = _checked(message).words
    check_protocol(words, "server")
    return words


def _checked(message: Message) -> Message:
    """Return an answer; raise the error that it tells."""
    if message.words.get("ok") is False:
        told = message.words["error"]
        keys = ("code", "hint", "file", "frame", "node", "parameter")
        raise FlowabsError(told["message"], **{key: told[key] for key in keys if key in told})
    return message
