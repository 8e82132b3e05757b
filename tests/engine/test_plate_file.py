"""Nodes that read passes and have no file read the plate's, as a render with its passes is one file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.dry_run import dry_run
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.read_passes import read_depth, read_normal
from tests.io import renders
from tests.io.files import exr, planes

NODES = {
    "plate": {"type": "read@1"},
    "depth": {"type": "read_depth@1"},
    "normal": {"type": "read_normal@1"},
    "out": {"type": "write@1", "inputs": {"image": "plate", "z": "depth", "n": "normal"}},
}


def document(**nodes: Any) -> dict[str, Any]:
    return {"format": "flowabs.graph/1", "name": "passes", "nodes": NODES | nodes}


@pytest.fixture
def render(tmp_path: Path) -> str:
    for frame in (1, 2):
        renders.blender5(tmp_path / f"shot.{frame:04d}.exr")
    return str(tmp_path / "shot.####.exr")


def test_a_run_reads_the_passes_of_the_plate(render: str, tmp_path: Path) -> None:
    report = fa.run(document(), input=render, output=tmp_path / "out.####.exr")
    assert [frame.status for frame in report.frames] == ["done", "done"]
    depth = read_depth(tmp_path / "out.0002.exr", layer="z")
    np.testing.assert_array_equal(depth.pixels[..., 0], renders.depth())


def test_a_pass_with_a_file_of_its_own_keeps_it(render: str, tmp_path: Path) -> None:
    for frame in (1, 2):
        exr(tmp_path / f"z.{frame:04d}.exr", {"Y": np.full((24, 32), frame, np.float32)})
    own = {"depth.file": str(tmp_path / "z.####.exr")}
    fa.run(document(), input=render, output=tmp_path / "out.####.exr", set=own)
    assert (read_depth(tmp_path / "out.0002.exr", layer="z").pixels == 2).all()
    normal = read_normal(tmp_path / "out.0002.exr", layer="n")
    np.testing.assert_allclose(normal.pixels, renders.NORMAL, atol=1e-3)


def test_in_memory_in_a_session_and_in_a_dry_run(render: str, tmp_path: Path) -> None:
    file = render.replace("####", "0001")
    graph = load_graph(document()).with_set({"plate.file": file})
    np.testing.assert_array_equal(graph.run(outputs="depth")["depth"].pixels[..., 0], renders.depth())
    with fa.Session(graph) as session:
        np.testing.assert_array_equal(session.run("normal")["normal"].pixels, renders.NORMAL)
    assert dry_run(graph, RunOptions(output=tmp_path / "out.exr")).reads == (file,)


def test_a_plate_that_is_given_has_no_file(tmp_path: Path) -> None:
    plate = np.zeros((24, 32, 3), np.float32)
    with pytest.raises(CommandError, match=r"no file to read is set .*--set depth\.file=FILE") as caught:
        load_graph(document()).run(given={"plate": plate}, outputs="depth")
    assert caught.value.node == "depth"


def test_of_several_plates_the_one_called_plate_counts(render: str) -> None:
    file = render.replace("####", "0001")
    other = {"other": {"type": "read@1", "params": {"file": "elsewhere.exr"}}}
    graph = load_graph(document(**other)).with_set({"plate.file": file})
    assert graph.run(outputs="depth")["depth"].type == "depth"
    unnamed = {name if name != "plate" else "beauty": node for name, node in NODES.items()}
    unnamed["out"] = {"type": "write@1", "inputs": {"image": "beauty", "z": "depth"}}
    unnamed["beauty"] = {"type": "read@1", "params": {"file": file}}
    with pytest.raises(CommandError, match="no file to read is set"):
        load_graph(document() | {"nodes": unnamed | other}).run(outputs="depth")


def test_a_file_that_a_knob_sets_is_shared_with_the_knob(render: str) -> None:
    shared = document(plate={"type": "read@1", "params": {"file": {"from": "render"}}})
    shared["interface"] = {"render": {"type": "string", "default": ""}}
    graph = load_graph(shared)
    out = graph.run(set={"render": render.replace("####", "0002")}, outputs="depth")["depth"]
    np.testing.assert_array_equal(out.pixels[..., 0], renders.depth())


def test_passes_that_a_plate_does_not_have(tmp_path: Path) -> None:
    path = exr(tmp_path / "beauty.exr", planes(np.random.default_rng(1).random((24, 32, 3), np.float32)))
    graph = load_graph(document()).with_set({"plate.file": str(path)})
    with pytest.raises(fa.FlowabsError, match="no depth in the file: in its only layer, R, G, B") as caught:
        graph.run(outputs="depth")
    assert caught.value.node == "depth"
