"""A server as a child process, and messages to it byte by byte: what a host written in another language does."""

import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np

import flowabs_nodes
from flowabs_nodes.serve.framing import packed, read_message, write_message

PLACE = str(Path(flowabs_nodes.__file__).parents[1])
ENVIRONMENT = {**os.environ, "PYTHONPATH": PLACE}

#: Seconds that a busy machine may take for what is done at once.
PATIENCE = 60

#: A node that is at work for minutes on the picture of :func:`slow_plate`.
SLOW = {"type": "bilateral@1", "inputs": {"image": "plate"}, "params": {"sigma_d": 30, "iterations": 50}}


def document(**node):
    """Return a graph file: plate -> bright -> out, with a knob ``stops``; or with another node as ``bright``."""
    bright = {"type": "exposure@1", "inputs": {"image": "plate"}, "params": {"stops": {"from": "stops"}}}
    return {
        "format": "flowabs.graph/1",
        "name": "bright",
        "description": "Brighter.",
        "interface": {"stops": {"type": "float", "default": 1.0, "min": -5, "max": 5, "unit": "", "help": "Stops."}},
        "nodes": {
            "plate": {"type": "read@1"},
            "bright": node or bright,
            "out": {"type": "write@1", "inputs": {"image": "bright"}},
        },
    }


def graph_file(folder, name="bright.json", **node):
    """Write that graph, and return its path."""
    path = Path(folder) / name
    path.write_text(json.dumps(document(**node)), encoding="utf-8")
    return str(path)


def plate(height=12, width=20, channels=4, seed=1):
    """Return premultiplied float32 pixels with alpha above 0, some above white."""
    pixels = np.random.default_rng(seed).random((height, width, channels), np.float32)
    pixels[..., :3] *= 1.5
    if channels == 4:
        pixels[..., 3] = pixels[..., 3] * 0.9 + 0.1
        pixels[..., :3] *= pixels[..., 3:]
    return pixels


def slow_plate():
    """Return a plate that keeps :data:`SLOW` at work for minutes."""
    return plate(400, 400)


class Wire:
    """A server, and its pipes. ``program`` runs in place of ``flowabs serve``."""

    def __init__(self, *arguments, program=None, env=None):
        command = ["-m", "flowabs_nodes", "serve"] if program is None else ["-c", program]
        self.process = subprocess.Popen(
            [sys.executable, "-P", *command, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            env={**ENVIRONMENT, **(env or {})},
        )

    def line(self):
        """Return the line of JSON that a server of several clients prints first."""
        text = b""
        while not text.endswith(b"\n"):
            got = self.process.stdout.read(1)
            assert got, self.process.communicate()[1].decode()
            text += got
        return json.loads(text)

    def send(self, words, *payload):
        """Send a message."""
        write_message(self.process.stdin, packed(words, payload))

    def raw(self, data):
        """Send bytes."""
        write_message(self.process.stdin, [memoryview(data)])

    def message(self):
        """Return the next message's words; None at the end."""
        message = read_message(self.process.stdout, 2**30)
        return None if message is None else message.words

    def answer(self, number):
        """Return the answer of a request; events before it are passed over."""
        while (words := self.message()) is not None:
            if words.get("id") == number and "event" not in words:
                return words
        raise AssertionError(self.process.communicate()[1].decode())

    def until_at_work(self, number, node="bright"):
        """Read until the node of a render with ``events`` is at work."""
        while (words := self.message()) is not None:
            event = words.get("event", {})
            if words.get("id") == number and event.get("node") == node and event["status"] == "started":
                return
            assert words.get("ok") is not False, words
        raise AssertionError(self.process.communicate()[1].decode())

    def end(self, seconds=PATIENCE):
        """Wait for the server's end; return its exit code and what it wrote on stderr."""
        _, errors = self.process.communicate(timeout=seconds)
        return self.process.returncode, errors.decode()

    def __enter__(self):
        return self

    def __exit__(self, *error):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


def render_slow(number, graph, events=True):
    """Return the request that renders the slow plate, and its payload."""
    height, width = slow_plate().shape[:2]
    picture = {"memory": None, "width": width, "height": height}
    words = {"id": number, "do": "render", "session": "a", "graph": graph, "events": events}
    return {**words, "given": {"plate": picture}, "into": {"bright": {}}}, slow_plate()


def header(magic=b"FLABS1\0\0", size=2):
    """Return a header."""
    return struct.pack("<8sII", magic, size, 0)
