"""The server: over the pipes of one host, or to several clients over a socket, until the host or a signal ends it."""

from __future__ import annotations

import hmac
import itertools
import socket
import threading
from contextlib import suppress
from typing import Any

from flowabs_nodes import stopping
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.serve.connection import Connection, Outbox
from flowabs_nodes.serve.framing import (
    BadMessage,
    ByteStream,
    check_protocol,
    packed,
    read_message,
    write_message,
)
from flowabs_nodes.serve.rendering import failure
from flowabs_nodes.serve.sessions import Sessions

_HEARTBEAT = 0.1  # seconds between two looks at whether a signal came
_MOST_CLIENTS = 64
_PATIENCE = 10.0  # seconds that a client may take to say its token
_MOST_FIRST_WORDS = 4096  # bytes of the message that says it
_LAST_WORDS = 0.5  # seconds that a client may take to hear why its connection ends
_MOST_UNREAD = 64  # pieces of 64 kB that it may have sent in vain


class Server:
    """Serves clients with the sessions of one process. ``max_pixels`` are the most that a picture may have."""

    def __init__(self, sessions: Sessions, max_pixels: int) -> None:
        self._sessions, self._max_pixels = sessions, max_pixels
        self._over = threading.Event()
        self._error: BadMessage | None = None
        self._numbers = itertools.count(1)
        self._clients = threading.BoundedSemaphore(_MOST_CLIENTS)

    def end(self) -> None:
        """Have :meth:`wait` return; any thread may call this."""
        self._over.set()

    def wait(self) -> None:
        """Wait until the server is to end.

        Raises
        ------
        BadMessage
            The host on the other end of the pipes sent something else.
        Stopped
            A signal asks the process to stop.
        """
        while not self._over.wait(_HEARTBEAT):
            stopping.check()
        if self._error is not None:
            raise self._error

    # ------------------------------------------------------------------ one host

    def serve_host(self, reads: ByteStream, writes: ByteStream) -> None:
        """Serve the host on the other end of two pipes, in a thread; the server ends when it leaves."""

        def serve() -> None:
            outbox = Outbox(writes, self.end)
            self._error = self._connection(reads, outbox).serve()
            outbox.close()
            self.end()

        threading.Thread(target=serve, name="flowabs-client", daemon=True).start()

    def _connection(self, reads: ByteStream, outbox: Outbox) -> Connection:
        return Connection(next(self._numbers), reads, outbox, self._sessions, self._max_pixels, self.end)

    # ------------------------------------------------------------------ several clients

    def serve_clients(self, listener: socket.socket, token: str) -> None:
        """Serve, in threads, whoever connects to a listening socket and says the token."""

        def accept() -> None:
            with suppress(OSError):  # closed: the server ends
                while True:
                    client, _ = listener.accept()
                    name = "flowabs-client"
                    threading.Thread(target=self._serve_client, args=(client, token), name=name, daemon=True).start()

        threading.Thread(target=accept, name="flowabs-accept", daemon=True).start()

    def _serve_client(self, client: socket.socket, token: str) -> None:
        """Serve one client, if it says the token, and close its socket."""
        with client, suppress(OSError):
            if client.family == socket.AF_INET:
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            stream: Any = socket.SocketIO(client, "rwb")
            if not self._clients.acquire(blocking=False):
                _tell(stream, FlowabsError(f"{_MOST_CLIENTS} clients are connected already", code="too-many"))
                return
            try:
                refused = _refused(client, stream, token)
                if refused is None:
                    outbox = Outbox(stream, lambda: _shut(client))
                    self._connection(stream, outbox).serve()
                    outbox.close()
                else:
                    _tell(stream, refused)
                _hang_up(client)
            finally:
                self._clients.release()


def _refused(client: socket.socket, stream: ByteStream, token: str) -> FlowabsError | None:
    """Hear what a client says first, within some seconds; return why it may not go on, None where it may."""
    late = threading.Timer(_PATIENCE, _shut, [client])
    late.daemon = True
    late.start()
    try:
        message = read_message(stream, 0, _MOST_FIRST_WORDS)
        words = {} if message is None else message.words
        check_protocol(words, "client")
    except BadMessage as error:
        return error
    finally:
        late.cancel()
    said = words.get("token")
    if isinstance(said, str) and hmac.compare_digest(said.encode("utf-8", "replace"), token.encode()):
        return None
    return FlowabsError("the first message has to say the token that the server printed", code="bad-token")


def _tell(stream: ByteStream, error: FlowabsError) -> None:
    """Tell a client why it is not served."""
    with suppress(OSError):
        write_message(stream, packed({"id": None, **failure(error)}))


def _hang_up(client: socket.socket) -> None:
    """End a connection so that the last words arrive: a system that is closed with bytes unread drops them."""
    with suppress(OSError):
        client.shutdown(socket.SHUT_WR)
        client.settimeout(_LAST_WORDS)
        for _ in range(_MOST_UNREAD):
            if not client.recv(2**16):
                return


def _shut(client: socket.socket) -> None:
    """End a connection, so that whoever reads it hears of its end."""
    with suppress(OSError):
        client.shutdown(socket.SHUT_RDWR)
