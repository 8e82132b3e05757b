"""Messages: what goes in comes out; what is none is refused in a sentence; half of one is the end."""

import io
from contextlib import suppress

import numpy as np
import pytest

from flowabs_nodes.serve.framing import BadMessage, check_protocol, packed, read_message, write_message
from tests.serve.wire import header


def stream(*data):
    return io.BytesIO(b"".join(data))


def encoded(words, *payload):
    out = io.BytesIO()
    write_message(out, packed(words, payload))
    return out.getvalue()


class Dribbling(io.RawIOBase):
    """Takes and gives three bytes at a time."""

    def __init__(self, data=b""):
        self.data = data

    def readinto(self, buffer):
        part = self.data[: min(3, len(buffer))]
        buffer[: len(part)] = part
        self.data = self.data[len(part) :]
        return len(part)

    def write(self, data):
        self.data += bytes(data[:3])
        return min(3, len(data))


def test_a_message_comes_as_it_went():
    pixels = np.arange(6, dtype=np.float32).reshape(1, 2, 3)
    data = encoded({"id": 1, "text": "größer"}, pixels, b"abc")
    message = read_message(stream(data), 100)
    assert message.words == {"id": 1, "text": "größer", "payload": 27}
    assert message.payload.tobytes() == pixels.tobytes() + b"abc"


def test_streams_may_take_and_give_less_than_they_are_asked():
    out = Dribbling()
    write_message(out, packed({"id": 7}, [b"0123456789"]))
    message = read_message(out, 10)
    assert message.words["id"] == 7
    assert message.payload.tobytes() == b"0123456789"


@pytest.mark.parametrize("length", [0, 5, 16, 20, 35])
def test_a_stream_that_ends_within_a_message_has_no_more(length):
    data = encoded({"id": 1}, b"0123456789")
    assert len(data) > 36
    assert read_message(stream(data[:length]), 10) is None


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"GET / HTTP/1.1\r\nHost: x\r\n", "expected a message"),
        (header(b"FLABS2\0\0"), "speaks protocol '2', this is flowabs"),
        (header(size=2**32 - 1), "expected 2 to 8388608 bytes of JSON, found 4294967295"),
        (header(size=0), "found 0"),
        (header(size=4) + b"nope", "expected JSON"),
        (header(size=2) + b"\xff\xfe", "expected JSON"),
        (header(size=2) + b"[]", "expected an object"),
        (header(size=9) + b'{"a":NaN}', "NaN is no number"),
        (header(size=100_000) + b"[" * 100_000, "expected JSON"),
        (header(size=15) + b'{"payload": -1}', "expected 0 to 10 bytes, found -1"),
        (header(size=15) + b'{"payload": 11}', "expected 0 to 10 bytes, found 11"),
        (header(size=17) + b'{"payload": true}', "found True"),
    ],
)
def test_what_is_no_message_is_refused_in_a_sentence(data, said):
    with pytest.raises(BadMessage, match=r"^payload: |^expected|^the other side|JSON") as raised:
        read_message(stream(data), 10)
    assert said in str(raised.value)


def test_no_memory_is_taken_for_bytes_that_do_not_come():
    text = b'{"payload": 1099511627776}'  # a terabyte: NumPy may refuse it, but nothing else may happen
    with suppress(MemoryError):
        assert read_message(stream(header(size=len(text)), text), 2**41) is None


def test_another_protocol_is_told_with_the_cure():
    check_protocol({"protocol": 1}, "client")
    check_protocol({}, "client")
    with pytest.raises(BadMessage, match=r"the client speaks protocol 2, this is flowabs .* of protocol 1") as raised:
        check_protocol({"protocol": 2}, "client")
    assert raised.value.code == "other-protocol"
    assert "same version" in raised.value.hint
