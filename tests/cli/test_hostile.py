"""Hostile graphs and paths: each is refused at once, without a traceback, and nothing is written, least of all outside.

How much memory hostile JSON takes is measured in tests/graph/test_safe_json.py; here a few commands by limits.
"""

import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import cli
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.render_sequence import render_sequence

pytestmark = pytest.mark.skipif(os.name == "nt", reason="links, pipes and devices of Unix")


def graph(*, plate=None, out=None, **changes):
    """Return a graph that copies a plate: parameters of its read and write, and other entries of the document."""
    nodes = {
        "plate": {"type": "read@1", "params": {"file": "in.1.exr"} | (plate or {})},
        "blurred": {"type": "blur@1", "inputs": {"image": "plate"}},
        "out": {"type": "write@1", "inputs": {"image": "blurred"}, "params": {"file": "out.exr"} | (out or {})},
    }
    return {"format": "flowabs.graph/1", "nodes": nodes} | changes


def with_node(name, **node):
    """Return the graph with one more node, or with other entries in one of its nodes."""
    document = graph()
    document["nodes"][name] = document["nodes"].get(name, {}) | node
    return document


@pytest.fixture
def shot(tmp_path, monkeypatch):
    """A root with a plate, as the current folder, and beside it what nobody may read or write."""
    root, outside = tmp_path / "root", tmp_path / "outside"
    root.mkdir()
    outside.mkdir()
    image = oiio.ImageBuf(oiio.ImageSpec(8, 6, 3, "half"))
    image.set_pixels(image.roi, np.full((6, 8, 3), 0.25, np.float32))
    for path in (root / "in.1.exr", root / "in.2.exr", outside / "secret.1.exr"):
        assert image.write(str(path))
    (root / "folder.exr").mkdir()
    (root / "link").symlink_to(outside)
    (root / "chain").symlink_to("link")
    (root / "link.exr").symlink_to(outside / "secret.1.exr")
    (root / "dangling.exr").symlink_to(outside / "new.exr")
    (root / "loop.exr").symlink_to("loop.exr")
    (root / "zero.exr").symlink_to("/dev/zero")
    os.mkfifo(root / "pipe.exr")
    os.mkfifo(root / "pipe.json")
    with socket.socket(socket.AF_UNIX) as listening:
        monkeypatch.chdir(root)
        listening.bind("socket.exr")
        (root / "copy.json").write_text(json.dumps(graph()), encoding="utf-8")
        yield root


def everything(folder: Path) -> dict[str, object]:
    """Return all names below a folder, of files with their size and time."""
    found = {}
    for path in folder.rglob("*"):
        state = path.lstat()
        found[str(path)] = (state.st_mode, state.st_size, state.st_mtime_ns) if not path.is_dir() else state.st_mode
    return found


def refused(shot, capsys, arguments, within=3.0):
    """Run a command, and assert that it is refused: soon, and with nothing changed. Return what it says."""
    before = everything(shot.parent)
    began = time.process_time()
    code = cli.main(["run", *arguments])
    seconds = time.process_time() - began  # well under one when alone
    said = capsys.readouterr().err
    assert code in (1, 2), said
    assert "Traceback" not in said
    assert "internal error" not in said.lower()
    assert said.strip()
    assert everything(shot.parent) == before
    assert seconds < within
    return said


def test_what_is_refused_below_is_refused_for_one_thing(shot):
    """The graph that every case changes is good, and so is the command."""
    assert cli.main(["run", "./copy.json", "--root", ".", "--log-file", "run.log"]) == 0
    assert (shot / "out.exr").exists()


PATHS = [
    *("../outside/secret.1.exr", "{outside}/secret.1.exr", "link/secret.1.exr", "chain/secret.1.exr", "link.exr"),
    *("../root/../outside/secret.1.exr", "./link/../outside/secret.1.exr", "//{outside}/secret.1.exr", "loop.exr"),
    *(
        "/proc/self/root/{outside}/secret.1.exr",
        "/proc/self/cwd/../outside/secret.1.exr",
        "~/secret.exr",
        "$HOME/a.exr",
    ),
    *("file://{outside}/secret.1.exr", "http://localhost/a.exr", "s3://bucket/a.exr", "/dev/zero", "/dev/stdin"),
    *("/dev/random", "zero.exr", "pipe.exr", "socket.exr", "folder.exr", "/etc/passwd", "a\0b.exr"),
    *("a" * 5000 + ".exr", "a/" * 3000 + "b.exr", "`id`.exr", "$(id).exr", "[python id].exr", "%0999d.exr"),
]


@pytest.mark.parametrize("path", PATHS, ids=lambda path: ascii(path[:40]))
def test_a_path_to_read(shot, capsys, path):
    name = path.format(outside=shot.parent / "outside")
    (shot / "copy.json").write_text(json.dumps(graph(plate={"file": name})), encoding="utf-8")
    refused(shot, capsys, ["./copy.json", "--root", "."])


OUTPUTS = [
    *("../outside/new.exr", "{outside}/new.exr", "link/new.exr", "chain/deep/er/new.exr", "dangling.exr", "link.exr"),
    *("file://{outside}/new.exr", "/dev/full", "pipe.exr", "socket.exr", "folder.exr", "in.1.exr", "copy.json"),
    *("../outside/new.####.png", "zero.exr", "/proc/self/mem", "loop.exr", "out.sh", "a\0b.exr", ""),
]


@pytest.mark.parametrize("path", OUTPUTS, ids=lambda path: ascii(path[:40]))
def test_a_path_to_write(shot, capsys, path):
    name = path.format(outside=shot.parent / "outside")
    (shot / "copy.json").write_text(json.dumps(graph(out={"file": name})), encoding="utf-8")
    refused(shot, capsys, ["./copy.json", "--root", "."])


DOCUMENTS = {
    "code in a type": with_node("evil", type="os:system@1"),
    "a dunder type": with_node("evil", type="__import__@1"),
    "a dunder parameter": with_node("blurred", params={"__class__": "os"}),
    "a dunder output": with_node("blurred", inputs={"image": "plate.__class__"}),
    "a path for a number": with_node("blurred", params={"sigma": "/etc/passwd"}),
    "a path in a curve": with_node("blurred", params={"sigma": {"curve": {"1": "/etc/passwd"}}}),
    "a curve of a path": graph(plate={"file": {"curve": {"1": "../outside/secret.1.exr"}}}),
    "a path in a knob": graph(
        plate={"file": {"from": "f"}}, interface={"f": {"type": "string", "default": "../outside/secret.1.exr"}}
    ),
    "a map of a path": graph(
        plate={"file": {"from": "f", "map": [[0, "/etc/passwd"]]}},
        interface={"f": {"type": "float", "default": 0, "min": 0, "max": 1}},
    ),
    "a file as a key": graph(file="/etc/passwd"),
    "a script": graph(python="import os"),
    "a cycle": with_node("blurred", inputs={"image": "blurred"}),
    "a cycle of masks": with_node("blurred", inputs={"image": "plate", "mask": "blurred"}),
    "an unhashable link": with_node("blurred", inputs={"image": ["plate"]}),
    "a huge sigma": with_node("blurred", params={"sigma": 1e300}),
    "a huge whole number": with_node("blurred", params={"sigma": 10**290}),
    "a name with a slash": with_node("../x", type="read@1"),
    "a name with NUL": with_node("x\0", type="read@1"),
    "a long name": with_node("n" * 1_000_000, type="read@1"),
    "a long text": graph(plate={"layer": "x" * 7_000_000}, nane=1),
    "another format": graph(format="flowabs.graph/999"),
    "nodes in a list": graph(nodes=[1, 2]),
    "no nodes": {"format": "flowabs.graph/1"},
    "10,001 nodes": graph(nodes={f"n{i}": {"type": "read@1"} for i in range(10_001)}),
    "a cycle of 10,000": graph(
        nodes={f"n{i}": {"type": "blur@1", "inputs": {"image": f"n{(i + 1) % 10_000}"}} for i in range(10_000)}
    ),
}
TEXTS = {
    "NaN": '{"format": "flowabs.graph/1", "nodes": {}, "reference_height": NaN}',
    "1e999": '{"format": "flowabs.graph/1", "nodes": {}, "reference_height": 1e999}',
    "a key twice": '{"format": "flowabs.graph/1", "nodes": {}, "nodes": {}}',
    "100,000 levels": "[" * 100_000 + "]" * 100_000,
    "100,000 objects": '{"a":' * 100_000,
    "half a surrogate": '{"format": "flowabs.graph/1", "name": "\\ud800", "nodes": {}}',
    "many digits": '{"format": "flowabs.graph/1", "nodes": {}, "reference_height": ' + "9" * 100_000 + "}",
    "9 MB": " " * 9_000_000,
    "no text": "\0\1\2",
    "nothing": "",
}


@pytest.mark.parametrize("name", [*DOCUMENTS, *TEXTS])
def test_a_graph(shot, capsys, name):
    text = TEXTS[name] if name in TEXTS else json.dumps(DOCUMENTS[name])
    (shot / "copy.json").write_text(text, encoding="utf-8")
    refused(shot, capsys, ["./copy.json", "--root", "."], within=6.0 if "10," in name else 3.0)


@pytest.mark.parametrize(
    "path", ["./pipe.json", "/dev/zero/", "/dev/random", "./folder.exr", "./none.json", "a/\0.json"]
)
def test_a_graph_that_is_no_file(shot, capsys, path):
    refused(shot, capsys, [path, "--root", "."])


@pytest.mark.parametrize("path", ["../outside/run.log", "link/run.log", "pipe.exr", "folder.exr", "in.1.exr"])
def test_a_log(shot, capsys, path):
    refused(shot, capsys, ["./copy.json", "--root", ".", "--log-file", path])


@pytest.mark.parametrize("path", ["./pipe.json", "./folder.exr", "none.ocio", "/dev/zero"])
def test_a_config(shot, capsys, path):
    refused(shot, capsys, ["./copy.json", "--root", ".", "--ocio", path])


@pytest.mark.parametrize("which", ["in", "out"])
def test_a_link_that_is_swapped_in_during_the_run(shot, which):
    """The second frame's folder becomes a link to the outside while the first frame is made."""
    for name in ("in", "out"):
        (shot / name).mkdir()
    for frame in (1, 2):
        (shot / f"in/p.{frame:04}.exr").write_bytes((shot / "in.1.exr").read_bytes())
    outside = shot.parent / "outside"
    (outside / "p.0002.exr").write_bytes((shot / "in.1.exr").read_bytes())

    def swap(event):
        if event["event"] == "frame" and event["frame"] == 1:
            (shot / which).rename(shot / "moved")
            (shot / which).symlink_to(outside)

    options = RunOptions(input="in/p.####.exr", output="out/q.####.exr", root=shot, jobs=1)
    before = everything(outside)
    report = render_sequence(graph(plate={"file": ""}, out={"file": ""}), options, on_event=swap)
    assert [frame.status for frame in report.frames] == ["done", "failed"]
    assert report.frames[1].error.code == "outside-root"
    assert everything(outside) == before


MEASURE = """
import re, sys, time
from flowabs_nodes import cli
began = time.process_time()
code = cli.main(sys.argv[1:])
seconds = time.process_time() - began
# Of this process alone: getrusage would count the one that started it as well.
peak = re.search(r"VmHWM:\\s+(\\d+) kB", open("/proc/self/status").read())
print(code, seconds, int(peak[1]) / 1024)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="measures memory as Linux counts it")
@pytest.mark.parametrize("path", ["pipe.exr", "zero.exr", "../outside/secret.1.exr", "bomb.exr"])
def test_a_refusal_takes_little_memory(shot, path):
    """The last is a small and whole file of 16384 x 8448 pixels."""
    if path == "bomb.exr":
        bomb = oiio.ImageOutput.create(path)
        spec = oiio.ImageSpec(16384, 8448, 1, oiio.HALF)
        spec.channelnames = ("Y",)
        assert bomb.open(path, spec)
        for row in range(0, 8448, 256):
            bomb.write_scanlines(row, row + 256, 0, np.zeros((256, 16384, 1), np.float16))
        bomb.close()
    (shot / "copy.json").write_text(json.dumps(graph(plate={"file": path})), encoding="utf-8")
    command = [sys.executable, "-c", MEASURE, "run", "./copy.json", "--root", "."]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment)
    code, seconds, megabytes = map(float, done.stdout.splitlines()[-1].split())
    assert code in (1, 2)
    assert seconds < 3  # well under one when alone
    assert megabytes < 200
    assert "Traceback" not in done.stderr
