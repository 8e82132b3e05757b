"""Put messages on a stream of bytes, and take them off: a header, an object of JSON, and perhaps pixels behind it.

The header has 16 bytes: ``FLABS1`` and two zeros, the bytes of JSON as uint32 of little endian, and a zero of four
bytes. The digit is that of the protocol. Where the object has ``payload``, so many bytes follow it.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

import flowabs_nodes
from flowabs_nodes.errors import FlowabsError

#: The number of what server and clients say to each other; another number is another language.
PROTOCOL = 1

MAGIC = b"FLABS1\0\0"
HEADER = struct.Struct("<8sII")

#: The most bytes of JSON in a message.
MOST_JSON = 8 * 2**20

#: Bytes that can be sent as they are.
Buffer = bytes | memoryview | npt.NDArray[Any]


class ByteStream(Protocol):
    """What messages are read from and written to: an unbuffered file or socket of Python."""

    def readinto(self, buffer: memoryview, /) -> int | None:
        """Read into a buffer, and return how many bytes; 0 at the end."""

    def write(self, data: memoryview, /) -> int | None:
        """Write some of the data, and return how many bytes."""


class BadMessage(FlowabsError):
    """What came is no message of this protocol; nothing that follows on its stream can be understood."""

    code = "bad-message"


@dataclass(frozen=True)
class Message:
    """An object of JSON, and the bytes that came with it."""

    words: dict[str, Any]
    payload: npt.NDArray[np.uint8]


def greeting() -> dict[str, Any]:
    """Return the first words of a server: its version, and its protocol."""
    return {"flowabs": flowabs_nodes.__version__, "protocol": PROTOCOL}


def check_protocol(words: Mapping[str, Any], who: str) -> None:
    """Raise BadMessage where ``words`` say another protocol; ``who`` said them."""
    number = words.get("protocol", PROTOCOL)
    if number != PROTOCOL:
        raise BadMessage(
            f"the {who} speaks protocol {number!r}, this is flowabs {flowabs_nodes.__version__} of protocol {PROTOCOL}",
            code="other-protocol",
            hint="install the same version of flowabs for both",
        )


def read_message(stream: ByteStream, most_payload: int, most_json: int = MOST_JSON) -> Message | None:
    """Return the next message; None where the stream ends, in the middle of one too.

    Raises
    ------
    BadMessage
        No message of this protocol, or longer than allowed: ``most_json`` bytes of JSON, ``most_payload`` behind it.
    """
    header = _read(stream, HEADER.size)
    if header is None:
        return None
    magic, size, _ = HEADER.unpack(header)
    if magic != MAGIC:
        if magic[:5] == MAGIC[:5]:
            check_protocol({"protocol": magic[5:6].decode("ascii", "replace")}, "other side")
        raise BadMessage(f"expected a message, which begins with {MAGIC!r}, found {magic!r}")
    if not 2 <= size <= most_json:
        raise BadMessage(f"expected 2 to {most_json} bytes of JSON, found {size}")
    text = _read(stream, size)
    if text is None:
        return None
    words = _parsed(text.tobytes())
    count = words.get("payload", 0)
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= most_payload:
        raise BadMessage(
            f"payload: expected 0 to {most_payload} bytes, found {str(count)[:40]}", code="too-big", parameter="payload"
        )
    payload = _read(stream, count)
    return None if payload is None else Message(words, payload)


def _parsed(text: bytes) -> dict[str, Any]:
    """Return the object that JSON describes; raise BadMessage for anything else."""
    try:
        words = json.loads(text.decode("utf-8"), parse_constant=_refuse)
    except (ValueError, RecursionError) as error:  # ValueError: no UTF-8, no JSON, a number of too many digits
        raise BadMessage(f"expected JSON, found {text[:40]!r}: {error}") from None
    if not isinstance(words, dict):
        raise BadMessage(f"expected an object of JSON, found {text[:40]!r}")
    return words


def _refuse(constant: str) -> None:
    """Raise ValueError for the numbers that JSON does not have."""
    raise ValueError(f"{constant} is no number of JSON")


def _read(stream: ByteStream, count: int) -> Any:
    """Return the next ``count`` bytes, an array; None where the stream ends before."""
    result: Any = np.empty(count, np.uint8)  # takes memory as bytes come, whatever was announced
    left = memoryview(result)
    while left:
        got = stream.readinto(left)
        if not got:
            return None
        left = left[got:]
    return result


def packed(words: Mapping[str, Any], payload: Iterable[Buffer] = ()) -> list[memoryview]:
    """Return the bytes of a message, in parts to be written one after the other; ``payload`` is not copied."""
    buffers: Iterable[Any] = payload  # NumPy's types do not say that arrays are buffers
    parts = [memoryview(part).cast("B") for part in buffers]
    size = sum(part.nbytes for part in parts)
    text = json.dumps({**words, "payload": size} if parts else words, allow_nan=False).encode("ascii")
    return [memoryview(HEADER.pack(MAGIC, len(text), 0) + text), *parts]


def write_message(stream: ByteStream, parts: Iterable[memoryview]) -> None:
    """Write the parts of a message, all of each. Raises OSError where nobody reads."""
    for part in parts:
        left = part
        while left:
            left = left[stream.write(left) or 0 :]
