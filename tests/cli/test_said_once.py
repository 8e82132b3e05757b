"""What went wrong is told without a name said twice: "parameter radius: radius:", "frame 1 failed frame 1"."""

import re
from itertools import pairwise

import pytest

from flowabs_nodes.image import Image

FAULTS = [
    ("run", "lines", "-i", "none.exr", "-o", "out.exr"),
    ("run", "lines", "-i", "empty.exr", "-o", "out.exr"),
    ("run", "lines", "-i", "text.exr", "-o", "out.exr"),
    ("run", "lines", "-i", "none.####.exr", "-o", "out.####.exr", "--frames", "1-2"),
    ("run", "lines", "-i", "plate.exr", "-o", "text.exr"),
    ("run", "lines", "-i", "plate.exr", "-o", "plate.exr"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.jpg"),
    ("run", "lines", "-i", "plate.exr"),
    ("run", "lines", "-o", "out.exr"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--scale", "2"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--max-pixels", "10"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--set", "plate.layer=N"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--set", "plate.part=N"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--set", "flow.radius=-1"),
    ("run", "lines", "-i", "plate.exr", "-o", "out.exr", "--set", "out.keep_layers=N"),
    ("check", "none.json"),
    ("nodes", "none"),
]


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Make a folder with a plate, an empty file and a text, and go there."""
    monkeypatch.chdir(tmp_path)
    Image.from_array([[[0.2, 0.4, 0.6]] * 8] * 6).to_imagebuf().write("plate.exr")
    (tmp_path / "empty.exr").touch()
    (tmp_path / "text.exr").write_text("not a picture")


@pytest.mark.parametrize("command", FAULTS, ids=" ".join)
def test_no_name_is_said_twice(command, here, flowabs):
    code, out, err = flowabs(*command)
    assert code in (1, 2)
    for line in filter(None, [*out.splitlines(), *err.splitlines()]):
        assert not twice(line), line


def twice(line: str) -> list[str]:
    """Return what a line says twice: a word after itself, or a frame, node, parameter or file by its name again."""
    words = re.findall(r"[\w.#/-]*\w", line)
    repeated = [a for a, b in pairwise(words) if a == b and not a[0].isdigit()]
    named = re.findall(r"\b((?:frame|node|parameter) \w+)\b", line.replace("'", ""))
    files = [word for word in words if word.endswith((".exr", ".json", ".jpg"))]
    return repeated + [name for names in (named, files) for name in names if names.count(name) > 1]


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("node n: parameter radius: radius: expected a number", True),
        ("frame 1  failed  p.exr: frame 1: node plate: no such file", True),
        ("node out: parameter file: node 'out' writes a file, but none is set", True),
        ("p.exr: cannot be read: p.exr: no such file", True),
        ("frame 1  failed  p.exr: node plate: no such file", False),
        ("frame 1002  failed  p.exr: frame 1003: no such file", False),
    ],
)
def test_the_test_finds_what_it_looks_for(line, found):
    assert bool(twice(line)) == found
