"""Knobs at curves in a run: the frame's value everywhere, lengths scaled, keys of the value."""

import json

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.cli import main

CURVE = {"curve": {1: 1, 3: 3}}


def blurred(radius="radius", **changes):
    return {
        "format": "flowabs.graph/1",
        "interface": {"radius": {"type": "float", "default": 2.0, "min": 0, "max": 8, "unit": "px"}},
        "nodes": {
            "plate": {"type": "read@1"},
            "soft": {"type": "blur@1", "inputs": {"image": "plate"}, "params": {"sigma": {"from": radius}}},
            "out": {"type": "write@1", "inputs": {"image": "soft"}},
        },
    } | changes


def picture(height=40):
    return np.random.default_rng(2).random((height, 60, 3)).astype(np.float32)


@pytest.mark.parametrize("size", [{}, {"reference_size": {"shorter": 20}}])
def test_a_frame_is_that_of_the_value_on_it(size):
    graph = fa.load_graph(blurred(**size))
    given = {"plate": fa.Image.from_array(picture())}
    literals = [graph.run(given=given, set={"radius": value}, outputs="soft")["soft"].pixels for value in (1, 2, 3)]
    assert not np.array_equal(*literals[:2])
    for frame, expected in enumerate(literals, 1):
        found = graph.run(frame, given=given, set={"radius": CURVE}, outputs="soft")["soft"].pixels
        np.testing.assert_array_equal(found, expected)
    if size:
        plain = fa.load_graph(blurred()).run(given=given, set={"radius": 4}, outputs="soft")["soft"].pixels
        np.testing.assert_array_equal(literals[1], plain)  # twice the reference size, twice the length


@pytest.fixture
def shot(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for frame in (1, 2, 3):
        assert fa.Image.from_array(picture()).to_imagebuf().write(f"plate.{frame}.exr")
    (tmp_path / "g.json").write_text(json.dumps(blurred()))
    return ["run", "./g.json", "-i", "plate.#.exr", "-o", "out.#.exr"]


def test_from_the_command_line(shot, capsys):
    assert main([*shot, "--set", 'radius={"curve": {"1": 1, "3": 3}}']) == 0
    capsys.readouterr()
    assert main([*shot, "--set", "radius=2"]) == 0  # frame 2 has its key already
    assert "2 done, 1 skipped" in capsys.readouterr().out
    assert main([*shot, "--set", 'soft.sigma={"curve": {"1": 2.0, "3": 2}}']) == 0
    assert "3 skipped" in capsys.readouterr().out


def test_an_error_names_the_key(shot, capsys):
    assert main([*shot, "--set", 'radius={"curve": {"1": 1, "24": 9}}']) == 2
    said = capsys.readouterr().err
    assert "--set radius/curve/24\n  found     9\n  expected  a number from 0 to 8 (px)" in said
