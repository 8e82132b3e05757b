"""A bundle, built once, with a graph that has every kind of knob and clip; skipped where there is no C compiler."""

import json
import os
import shlex
import shutil
import stat
import sys
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.openfx import bundle
from tests.openfx.host import FILTER, Host
from tests.openfx.images import Held, Layout

#: A graph that is quick, with a knob of every type, a second plate, a depth, a matte, and two outputs.
PANEL = {
    "format": "flowabs.graph/1",
    "description": "Every kind of knob.",
    "interface": {
        "stops": {
            "type": "float",
            "default": 0.0,
            "min": -8,
            "max": 8,
            "unit": "stops",
            "help": "Light.",
            "group": "A & B",
        },
        "which": {"type": "int", "default": 0, "min": 0, "max": 1, "group": "Choice"},
        "how": {
            "type": "enum",
            "default": "plus",
            "choices": ["plus", "multiply", "over"],
            "label": "How it is merged",
        },
        "ink": {"type": "color", "default": [0.0, 0.25, 0.5], "group": "A & B"},
        "adaptive": {"type": "bool", "default": True},
        "turned": {"type": "string", "default": "R,G,B"},
        "moving": {"type": "float", "default": {"curve": {"1": 0, "11": 1}}},
        "mix": {"type": "float", "default": 1.0, "min": 0, "max": 1},
    },
    "nodes": {
        "plate": {"type": "read@1"},
        "other": {"type": "read@1"},
        "depth": {"type": "read_depth@1"},
        "bright": {"type": "exposure@1", "inputs": {"image": "plate"}, "params": {"stops": {"from": "stops"}}},
        "moved": {"type": "exposure@1", "inputs": {"image": "bright"}, "params": {"stops": {"from": "moving"}}},
        "turn": {"type": "invert@1", "inputs": {"image": "moved"}, "params": {"channels": {"from": "turned"}}},
        "pick": {"type": "switch@1", "inputs": {"a": "moved", "b": "turn"}, "params": {"which": {"from": "which"}}},
        "both": {
            "type": "merge@1",
            "inputs": {"B": "pick", "A": "other"},
            "params": {"operation": {"from": "how"}, "mix": {"from": "mix"}},
        },
        "paper": {"type": "matte@1", "inputs": {"image": "plate"}},
        "inked": {
            "type": "composite@1",
            "inputs": {"image": "moved", "lines": "paper"},
            "params": {"ink": {"from": "ink"}},
        },
        "far": {
            "type": "shuffle@1",
            "inputs": {"image": "depth"},
            "params": {"channels": {"R": "Z", "G": "Z", "B": "Z"}},
        },
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}, "params": {"adaptive": {"from": "adaptive"}}},
        "out": {
            "type": "write@1",
            "inputs": {"image": "pick", "both": "both", "inked": "inked", "far": "far", "flow": "flow"},
        },
    },
}

#: A graph without a size of its own, whose lengths follow the scale alone.
SOFT = {
    "format": "flowabs.graph/1",
    "interface": {"sigma": {"type": "float", "default": 4.0}},
    "nodes": {
        "plate": {"type": "read@1"},
        "soft": {"type": "blur@1", "inputs": {"image": "plate"}, "params": {"sigma": {"from": "sigma"}}},
        "out": {"type": "write@1", "inputs": {"image": "soft"}},
    },
}


def pytest_collection_modifyitems(items):
    if (sys.platform == "win32" or not compiler()) and items:
        why = "the test host runs on POSIX" if sys.platform == "win32" else "there is no C compiler (CC, cc or gcc)"
        here = Path(__file__).parent
        for item in items:
            if here in item.path.parents and "library" in getattr(item, "fixturenames", ()):
                item.add_marker(pytest.mark.skip(reason=why))


def compiler():
    """Return the C compiler that the build takes, or None."""
    words = shlex.split(os.environ.get("CC", "")) or ["cc" if shutil.which("cc") else "gcc"]
    return shutil.which(words[0])


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """Return the file of the plug-in in a bundle of its own, which also has the graphs of this file."""
    folder, graphs = tmp_path_factory.mktemp("ofx"), tmp_path_factory.mktemp("graphs")
    (graphs / "panel.json").write_text(json.dumps(PANEL))
    (graphs / "soft.json").write_text(json.dumps(SOFT))
    (graphs / "broken.json").write_text("{")
    made, problems = bundle.build(folder, [graphs])
    assert len(problems) == 1, problems
    assert "broken.json" in problems[0]
    return next(made.glob("Contents/*/Flowabs.ofx"))


@pytest.fixture(scope="session")
def kept_host(library):
    """Return a host that stays open for all tests that do it no harm: its server starts once."""
    host = Host(library)
    yield host
    host.close()


@pytest.fixture
def host(kept_host):
    """Return the host that stays open; whatever broke a rule in the test fails it."""
    kept_host.faults.clear()
    yield kept_host
    assert kept_host.faults == []


@pytest.fixture
def elsewhere(library, tmp_path):
    """Return a function that copies the bundle, with another server: a list of lines of server.txt, or a program."""

    def copied(*server, program=None, name="copy"):
        made = tmp_path / name / "Flowabs.ofx.bundle"
        shutil.copytree(library.parents[2], made)
        if program is not None:
            script = tmp_path / name / "server.py"
            script.write_text(f"#!{sys.executable}\n{FAKE}\n{program}\n")
            script.chmod(script.stat().st_mode | stat.S_IXUSR)
            server = (str(script),)
        if server:
            (made / "Contents" / "Resources" / "server.txt").write_text("\n".join(server) + "\n")
        return made / "Contents" / library.parent.name / library.name

    return copied


#: What a server that behaves badly begins with: it says hello, and reads messages.
FAKE = """
import json, os, struct, sys, time
MAGIC = b"FLABS1" + bytes(2)
def say(words, magic=MAGIC):
    body = json.dumps(words).encode()
    os.write(1, magic + struct.pack("<II", len(body), 0) + body)
def take(count):
    data = b""
    while len(data) < count:
        part = os.read(0, count - len(data))
        if not part:
            sys.exit(0)
        data += part
    return data
def hear():
    head = take(16)
    return json.loads(take(struct.unpack("<I", head[8:12])[0]))
"""


def picture(height=12, width=16, seed=1, alpha=False):
    """Return pixels (H, W, 4), premultiplied."""
    pixels = np.random.default_rng(seed).random((height, width, 4)).astype(np.float32)
    if not alpha:
        pixels[..., 3] = 1
    pixels[..., :3] *= pixels[..., 3:]
    return pixels


def instance_of(host, name, source, *, context=FILTER, layout=None, output=None):
    """Return an instance with a picture at its source, and an output of the same layout to be filled."""
    made = host.plugin(name).instance(context)
    layout = layout or Layout()
    made.clips["Source"].connect(Held(source, layout) if source is not None else None)
    target = np.full((*(source.shape[:2] if source is not None else (12, 16)), 4), 7, np.float32)
    made.clips["Output"].connect(output if output is not None else Held(target, layout))
    return made
