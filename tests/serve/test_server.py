"""The server under one host: what it prints, what it refuses, and how it ends."""

import os
import signal
import sys
import time

import numpy as np
import pytest

import flowabs_nodes
from tests.serve.wire import PATIENCE, Wire, header, plate, render_slow

GREETING = {"flowabs": flowabs_nodes.__version__, "protocol": 1}


@pytest.fixture
def wire():
    with Wire() as wire:
        assert wire.message() == GREETING
        yield wire


@pytest.fixture(scope="module")
def lasting():
    """Return a server for all tests that do not end it."""
    with Wire() as wire:
        assert wire.message() == GREETING
        yield wire


def render(number, graph, pixels, **changes):
    """Return the request that renders pixels that come with it."""
    height, width = pixels.shape[:2]
    picture = {"memory": None, "width": width, "height": height}
    words = {"id": number, "do": "render", "session": "s", "graph": graph, "given": {"plate": picture}}
    return {**words, "into": {"bright": {"channels": "RGB"}}, **changes}, pixels


def test_what_is_asked_is_answered_with_the_same_id(wire, graph):
    wire.send({"id": 5, "do": "hello", "protocol": 1})
    answer = wire.message()
    assert answer == {"id": 5, "ok": True, **GREETING, "pid": wire.process.pid, "threads": answer["threads"]}
    wire.send(*render(-3, graph, plate(), set={"stops": 0}))
    answer = wire.answer(-3)
    assert (answer["ok"], answer["payload"]) == (True, 12 * 20 * 3 * 4)
    wire.send({"id": 6, "do": "stop"})
    assert wire.message() == {"id": 6, "ok": True}
    assert wire.end() == (0, "")


def test_pictures_in_a_message_lie_one_behind_the_other_in_their_order(wire, graph):
    first, second = plate(), plate(3, 20)[::-1].copy()
    words, _ = render(1, graph, first)
    words["given"]["bright"] = {"memory": None, "width": 20, "height": 3, "row_bytes": -20 * 16}
    words["into"] = {"bright": {}, "plate": {}}
    wire.send(words, first, second)
    answer = wire.answer(1)
    assert answer["ok"], answer
    assert answer["payload"] == second.nbytes + first.nbytes
    assert [each["height"] for each in answer["pictures"].values()] == [3, 12]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"do": "hello"}, "id: expected a whole number, found None"),
        ({"id": "1", "do": "hello"}, "id: expected a whole number, found '1'"),
        ({"id": 1}, "do: expected a text"),
        ({"id": 1, "do": "rendr"}, "did you mean 'render'?"),
        ({"id": 1, "do": "render"}, "session: expected a text, found nothing"),
        (
            {"id": 1, "do": "render", "session": "a", "graph": "flat", "into": {"flat": 3}},
            "into.flat: expected an object",
        ),
        ({"id": 1, "do": "render", "session": "a", "grph": "flat"}, "grph: no such key (did you mean 'graph'?)"),
        ({"id": 1, "do": "hello", "protocol": 2}, "the client speaks protocol 2, this is flowabs"),
        ({"id": 1, "do": "map", "memory": 1, "bytes": 10}, "path: expected a text"),
        ({"id": 1, "do": "map", "memory": 1, "bytes": 2**60, "path": "/x"}, "bytes: expected 1 to"),
        ({"id": 1, "do": "map", "memory": 1, "bytes": 10, "path": "/dev/null"}, "plain file"),
        ({"id": 1, "do": "unmap", "memory": 8}, "no memory 8 is mapped"),
        ({"id": 1, "do": "describe", "graph": "flt"}, "did you mean 'flat'"),
        ({"id": 1, "do": "cancel", "of": None}, "of: expected a whole number"),
    ],
)
def test_a_wrong_request_is_answered_and_the_next_one_too(lasting, words, said):
    wire = lasting
    wire.send(words)
    answer = wire.message()
    assert (answer["id"], answer["ok"]) == (1 if words.get("id") == 1 else None, False)
    told = answer["error"]
    assert said in f"{told['message']} ({told.get('hint')})"
    wire.send({"id": 2, "do": "cancel", "of": 77})
    assert wire.message() == {"id": 2, "ok": True}


def test_an_id_that_is_at_work_is_refused(wire, slow):
    words, pixels = render_slow(1, slow)
    wire.send(words, pixels)
    wire.until_at_work(1)
    wire.send({**words, "id": 1}, pixels)
    assert "1 is at work already" in wire.answer(1)["error"]["message"]
    wire.process.stdin.close()
    wire.process.stdin = None


def test_cancel_is_heard_at_once_and_the_render_answers(wire, slow):
    wire.send(*render_slow(1, slow))
    wire.until_at_work(1)
    begun = time.monotonic()
    wire.send({"id": 2, "do": "cancel", "of": 1})
    found = {}
    while len(found) < 2:
        words = wire.message()
        if "event" not in words:
            found[words["id"]] = words
    assert time.monotonic() - begun < 2
    assert found[2] == {"id": 2, "ok": True}
    assert found[1]["error"]["code"] == "cancelled"


def test_a_session_that_is_forgotten_at_work_ends_its_render(wire, slow):
    wire.send(*render_slow(1, slow))
    wire.until_at_work(1)
    wire.send({"id": 2, "do": "forget", "session": "a"})
    assert wire.answer(1)["error"]["code"] == "cancelled"


@pytest.mark.parametrize(
    "data",
    [
        b"GET / HTTP/1.1\r\nHost: here\r\n\r\n",
        header(size=2**31),
        header(size=19) + b'{"payload": 1e+308}',
        b"\0" * 100,
    ],
)
def test_garbage_is_told_and_ends_it(wire, data):
    wire.raw(data)
    answer = wire.message()
    assert answer["id"] is None
    assert answer["error"]["code"] in ("bad-message", "too-big")
    assert wire.message() is None
    code, errors = wire.end()
    assert code == 2
    assert errors.startswith("flowabs: ")
    assert "Traceback" not in errors


def test_a_payload_beyond_max_pixels_is_refused_and_ends_it():
    with Wire("--max-pixels", "100") as wire:
        wire.message()
        wire.send({"id": 1, "do": "hello", "payload": 100 * 16 * 8 + 1})
        assert wire.message()["error"]["code"] == "too-big"
        assert wire.end()[0] == 2


@pytest.mark.parametrize("data", [b"", b"FLA", header(size=100) + b'{"id": 1,'])
def test_it_ends_when_the_host_dies_within_a_message_too(wire, data):
    wire.raw(data)
    wire.process.stdin.close()
    wire.process.stdin = None
    assert wire.end() == (0, "")


def test_it_ends_within_a_second_when_the_host_dies_though_a_render_is_at_work(wire, slow):
    wire.send(*render_slow(1, slow))
    wire.until_at_work(1)
    begun = time.monotonic()
    wire.process.stdin.close()
    wire.process.stdin = None
    assert wire.process.wait(PATIENCE) == 0
    assert time.monotonic() - begun < 3  # one, on a machine that does nothing else
    assert wire.process.stderr.read() == b""


def test_it_ends_when_nobody_reads_it(wire, graph):
    wire.process.stdout.close()
    pixels = plate(400, 400)
    wire.send(*render(1, graph, pixels))
    assert wire.process.wait(PATIENCE) == 0
    wire.process.stdout = None


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_though_a_render_is_at_work(wire, slow, number):
    wire.send(*render_slow(1, slow))
    wire.until_at_work(1)
    wire.process.send_signal(number)
    assert wire.end() == (128 + number, "")


HANGING = """
import threading, time
threading.Thread(target=lambda: time.sleep(1000), name="another package's").start()
from flowabs_nodes.__main__ import main
main("serve")
"""


@pytest.mark.parametrize(("last_words", "code"), [(b"", 0), (b"garbage, garbage", 2)])
def test_a_thread_of_another_package_does_not_keep_it(last_words, code):
    with Wire(program=HANGING) as wire:
        assert wire.message() == GREETING
        wire.raw(last_words)
        assert wire.end()[0] == code


NOISY = """
import os, sys
from flowabs_nodes.serve import describing
real = describing.described
def described(*arguments):
    print("Python prints")
    os.write(1, b"a C library prints\\n")
    os.system("echo a program prints")
    return real(*arguments)
describing.described = described
from flowabs_nodes.__main__ import main
main("serve")
"""


def test_whatever_is_printed_stdout_has_the_protocol_alone():
    with Wire(program=NOISY) as wire:
        assert wire.message() == GREETING
        wire.send({"id": 1, "do": "describe", "graph": "flat"})
        assert wire.answer(1)["name"] == "flat"
        wire.process.stdin.close()
        wire.process.stdin = None
        code, errors = wire.end()
    assert code == 0
    for who in ("Python", "a C library", "a program"):
        assert f"{who} prints" in errors


def test_pictures_in_memory_may_be_unmapped_while_they_are_filtered(wire, tmp_path, graph):
    path = tmp_path / "memory"
    pixels = plate(50, 60)
    path.write_bytes(pixels.tobytes() * 2)
    path.chmod(0o600)
    wire.send({"id": 1, "do": "map", "memory": 9, "path": str(path), "bytes": 2 * pixels.nbytes})
    assert wire.message() == {"id": 1, "ok": True}
    there = {"memory": 9, "width": 60, "height": 50}
    words = {"id": 2, "do": "render", "session": "s", "graph": graph, "given": {"plate": there}}
    wire.send({**words, "into": {"bright": {**there, "offset": pixels.nbytes}}})
    wire.send({"id": 3, "do": "unmap", "memory": 9})
    found = sorted((wire.message(), wire.message()), key=lambda words: words["id"])
    assert [each["ok"] for each in found] == [True, True], found
    made = np.frombuffer(path.read_bytes()[pixels.nbytes :], np.float32).reshape(pixels.shape)
    np.testing.assert_array_equal(made[..., :3], pixels[..., :3] * 2)
    assert os.path.exists(path)
