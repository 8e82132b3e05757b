"""Several clients: who may connect, and that none of them harms another; what is left at the end."""

import os
import signal
import socket
import stat
import sys
import time

import numpy as np
import pytest

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.serve.client import Client, ServerDied
from flowabs_nodes.serve.framing import packed, read_message, write_message
from tests.serve.wire import PATIENCE, Wire, header, plate, render_slow

KINDS = ["port"] if sys.platform == "win32" else ["port", "socket"]


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "private"
    folder.mkdir(mode=0o700)
    return folder


@pytest.fixture(params=KINDS, scope="module")
def lasting(request, tmp_path_factory):
    """Return such a server for all tests that do not end it."""
    folder = tmp_path_factory.mktemp("private", numbered=True)
    folder.chmod(0o700)
    with Wire(*where(request.param, folder)) as wire:
        yield wire, wire.line()


def where(kind, folder):
    return ["--port", "0"] if kind == "port" else ["--socket", str(folder / "flowabs")]


@pytest.fixture(params=KINDS)
def server(request, folder):
    """Return a server of several clients, and what it printed first."""
    with Wire(*where(request.param, folder)) as wire:
        yield wire, wire.line()


def connected(line):
    """Connect, and return the socket and its stream."""
    if line["address"].startswith("/"):
        client = socket.socket(socket.AF_UNIX)
        client.connect(line["address"])
    else:
        host, port = line["address"].split(":")
        client = socket.create_connection((host, int(port)))
    client.settimeout(PATIENCE)
    return client, socket.SocketIO(client, "rwb")


def say(stream, words, *payload):
    write_message(stream, packed(words, payload))


def hear(stream):
    message = read_message(stream, 2**20)
    return None if message is None else message.words


def test_clients_render_at_once_and_a_dead_or_mad_one_harms_no_other(server, graph, slow):
    _, line = server
    with Client.connect(line["address"], line["token"]) as client:
        dead, dead_stream = connected(line)
        say(dead_stream, {"token": line["token"]})
        hear(dead_stream)
        say(dead_stream, *render_slow(1, slow))
        while hear(dead_stream).get("event", {}).get("node") != "bright":
            pass
        mad, mad_stream = connected(line)
        say(mad_stream, {"token": line["token"], "protocol": 1})
        hear(mad_stream)
        mad.sendall(header(b"nonsense"))
        half, half_stream = connected(line)
        say(half_stream, {"token": line["token"]})
        hear(half_stream)
        half.sendall(header(size=1000) + b"{")
        out = client.render(graph, {"plate": plate()}, ["bright"], session="a")["bright"]
        np.testing.assert_array_equal(out[..., :3], plate()[..., :3] * 2)
        assert hear(mad_stream)["error"]["code"] == "bad-message"
        assert hear(mad_stream) is None
        for each in (dead, dead_stream, half, half_stream, mad, mad_stream):
            each.close()
        out = client.render(graph, {"plate": plate()}, ["bright"], session="a")["bright"]
        with Client.connect(line["address"], line["token"]) as other:
            both = other.render(graph, {"plate": plate()}, ["bright"], session="a", set={"stops": 0})["bright"]
        np.testing.assert_array_equal(both[..., :3], plate()[..., :3])


@pytest.mark.parametrize(
    ("first", "code"),
    [
        ({"token": "wrong"}, "bad-token"),
        ({"token": None}, "bad-token"),
        ({"token": 5}, "bad-token"),
        ({"token": "\ud800"}, "bad-token"),
        ({}, "bad-token"),
        ({"id": 1, "do": "stop"}, "bad-token"),
        ({"token": "x" * 5000}, "bad-message"),
        ({"payload": 5}, "too-big"),
        ({"protocol": 2}, "other-protocol"),
    ],
)
def test_without_the_token_nothing_is_served_and_the_connection_ends(lasting, first, code):
    wire, line = lasting
    client, stream = connected(line)
    say(stream, {"token": line["token"], **first} if first.get("protocol") else first)
    assert hear(stream)["error"]["code"] == code
    assert hear(stream) is None
    client.close()
    with Client.connect(line["address"], line["token"]) as good:
        assert good.hello()["pid"] == wire.process.pid


def test_a_wrong_token_is_an_error_of_the_client(lasting):
    _, line = lasting
    with pytest.raises(FlowabsError, match="the token that the server printed") as raised:
        Client.connect(line["address"], "wrong")
    assert raised.value.code == "bad-token"


def test_any_client_may_stop_it_and_nothing_is_left(server, folder):
    wire, line = server
    with Client.connect(line["address"], line["token"]) as client:
        client._plain({"do": "stop"})
        assert wire.end() == (0, "")
        with pytest.raises(ServerDied):
            client.hello()
    assert list(folder.iterdir()) == []
    with pytest.raises(ServerDied, match="no server listens"):
        Client.connect(line["address"], line["token"])


def test_it_ends_when_its_host_dies_though_a_render_is_at_work(server, slow, folder):
    wire, line = server
    client, stream = connected(line)
    say(stream, {"token": line["token"]})
    say(stream, *render_slow(1, slow))
    while hear(stream).get("event", {}).get("node") != "bright":
        pass
    begun = time.monotonic()
    assert wire.end() == (0, "")  # closes its stdin
    assert time.monotonic() - begun < 3
    client.close()
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_leaves_no_socket(folder, number):
    with Wire("--socket", str(folder / "flowabs")) as wire:
        line = wire.line()
        assert stat.S_IMODE(os.stat(line["address"]).st_mode) == 0o600
        wire.process.send_signal(number)
        assert wire.end() == (128 + number, "")
    assert list(folder.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="no such sockets")
def test_a_socket_whose_server_was_killed_is_taken_over_and_one_at_work_is_not(folder):
    path = str(folder / "flowabs")
    with Wire("--socket", path) as first:
        first.line()
        with Wire("--socket", path) as second:
            code, errors = second.end()
        assert (code, "another server listens here" in errors) == (2, True)
        first.process.kill()
        first.end()
    assert os.path.exists(path)
    with Wire("--socket", path) as third:
        assert third.line()["address"] == path
        assert third.end()[0] == 0
    assert not os.path.exists(path)


@pytest.mark.skipif(sys.platform == "win32", reason="no such sockets")
@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda folder: folder.chmod(0o755), "expected a folder of this user alone, 0700, found 0755"),
        (lambda folder: (folder / "flowabs").write_text("mine"), "expected a new name, or a server's socket"),
        (lambda folder: folder.rmdir(), "mkdir -m 700"),
    ],
)
def test_a_place_that_is_not_for_a_socket_is_refused(folder, make, said):
    make(folder)
    with Wire("--socket", str(folder / "flowabs")) as wire:
        code, errors = wire.end()
    assert code == 2
    assert said in errors
    assert "Traceback" not in errors


def test_the_token_may_be_given_and_not_be_short():
    given = "0123456789abcdef"
    with Wire("--port", "0", env={"FLOWABS_TOKEN": given}) as wire:
        assert wire.line()["token"] == given
    with Wire("--port", "0", env={"FLOWABS_TOKEN": "short"}) as wire:
        code, errors = wire.end()
    assert code == 2
    assert "expected at least 16 letters, found 5" in errors


def test_two_servers_have_two_tokens_and_a_port_is_taken_once():
    with Wire("--port", "0") as one:
        line = one.line()
        assert line["address"].startswith("127.0.0.1:")
        with Wire("--port", line["address"].split(":")[1]) as other:
            code, errors = other.end()
        assert (code, "cannot listen on port" in errors) == (2, True)
        with Wire("--port", "0") as other:
            assert other.line()["token"] != line["token"]
