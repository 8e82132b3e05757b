"""The nodes for passes: found in a render, used in a graph, and written again with every bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.nodes import catalogue
from tests.io import renders
from tests.io.files import box, colors, exr, native, planes, same_bits

READS = ("read_depth", "read_normal", "read_motion", "read_id")


def test_ports_and_defaults() -> None:
    nodes = catalogue()
    outputs = {name: [(port.name, port.types) for port in nodes[name].outputs] for name in READS}
    assert outputs == {
        "read_depth": [("depth", "depth")],
        "read_normal": [("normal", "normal")],
        "read_motion": [("motion", "motion")],
        "read_id": [("id", "id"), ("coverage", "mono")],
    }
    for name in READS:
        expected = {"layer": "", "part": "", "missing": "error"}
        own = {"read_motion": {"convention": "auto"}}.get(name, {} if name == "read_depth" else {"absent": "error"})
        assert nodes[name].defaults() == expected | own
        assert nodes[name].file_param is not None
        assert nodes[name].file_param.role == "input"  # type: ignore[union-attr]


def graph_of(file: Path, out: Path | None = None, **params: Any) -> dict[str, Any]:
    """Return a graph that reads a render's passes, and writes them beside its colour."""
    nodes: dict[str, Any] = {
        name.removeprefix("read_"): {"type": f"{name}@1", "params": {"file": str(file), **params}} for name in READS
    }
    nodes["plate"] = {"type": "read@1", "params": {"file": str(file)}}
    layers = {"d": "depth", "n": "normal", "m": "motion", "i": "id", "cover": "id.coverage"}
    if out:
        params = {"file": str(out), "data_type": "half"}
        nodes["out"] = {"type": "write@1", "inputs": {"image": "plate", **layers}, "params": params}
    return {"format": "flowabs.graph/1", "name": "passes", "nodes": nodes}


@pytest.mark.parametrize("render", [renders.blender45, renders.blender5, renders.arnold])
def test_read_and_written_again(tmp_path: Path, render: Any) -> None:
    path = render(tmp_path / "render.0001.exr")
    out = tmp_path / "out.0001.exr"
    graph = tmp_path / "graph.json"
    graph.write_text(json.dumps(graph_of(path, out)))
    report = fa.run(str(graph), frames="1")
    assert report.exit_code == 0
    found = native(out)
    assert same_bits(found["d.Z"], renders.depth())
    assert all(same_bits(found[f"n.{each}"], renders.NORMAL[..., i]) for i, each in enumerate("XYZ"))
    if render is not renders.arnold:
        assert all(same_bits(found[f"m.{each}"], renders.VECTOR[..., i]) for i, each in enumerate("XYZW"))
    assert found["i.id"].dtype == np.uint32
    assert set(np.unique(found["i.id"])) == {0, renders.BALL, renders.CRATE}
    assert found["cover.Y"].dtype == np.float16


def test_ids_of_an_id_pass_survive_read_and_write(tmp_path: Path) -> None:
    path = renders.arnold(tmp_path / "render.0001.exr")
    document = graph_of(path, tmp_path / "out.exr")
    document["nodes"]["id"]["params"]["layer"] = "ID"
    document["nodes"]["out"]["inputs"]["image"] = "id"
    del document["nodes"]["plate"]
    (tmp_path / "graph.json").write_text(json.dumps(document))
    assert fa.run(str(tmp_path / "graph.json"), frames="1").exit_code == 0
    found = native(tmp_path / "out.exr")
    for name in ("id", "i.id"):
        assert same_bits(found[name], renders.ARNOLD_IDS)


def test_a_smaller_run_takes_whole_values_and_shorter_motion(tmp_path: Path) -> None:
    path = renders.blender45(tmp_path / "a.exr")
    graph = fa.load_graph(graph_of(path))
    small = graph.run(scale=0.5, outputs=["depth", "normal", "motion", "id"])
    np.testing.assert_array_equal(small["depth"].pixels[..., 0], renders.depth()[1::2, 1::2])
    np.testing.assert_array_equal(small["normal"].pixels, renders.NORMAL[1::2, 1::2])
    np.testing.assert_array_equal(small["motion"].pixels, renders.VECTOR[1::2, 1::2] / 2)
    assert set(np.unique(small["id"].pixels)) == {0, renders.BALL, renders.CRATE}


def test_a_missing_frame_that_is_black_is_far_away_and_has_no_ids(tmp_path: Path) -> None:
    renders.blender45(tmp_path / "a.0001.exr")
    graph = fa.load_graph(graph_of(tmp_path / "a.####.exr", missing="black"))
    found = graph.run(frame=2, outputs=["depth", "id", "motion"])
    assert (found["depth"].pixels == 1e10).all()
    assert not found["id"].pixels.any()
    assert found["id"].pixels.dtype == np.uint32
    assert not found["motion"].pixels.any()


def test_a_matte_of_a_large_id(tmp_path: Path) -> None:
    path = exr(tmp_path / "a.exr", {"id": renders.IDS})
    document = graph_of(path)
    document["nodes"]["crate"] = {
        "type": "matte@1",
        "inputs": {"image": "id"},
        "params": {"low": renders.CRATE, "high": renders.CRATE},
    }
    found = fa.load_graph(document).run(outputs=["crate"])["crate"]
    np.testing.assert_array_equal(found.pixels[..., 0], (renders.IDS == renders.CRATE).astype(np.float32))


# ---------------------------------------------------------------------- passes that are not there


def absent_graph(file: Path, **params: Any) -> Any:
    """Return a graph that reads normals and ids of a file."""
    nodes = {
        "normal": {"type": "read_normal@1", "params": {"file": str(file), "absent": "empty", **params}},
        "ids": {"type": "read_id@1", "params": {"file": str(file), "absent": "empty", **params}},
    }
    return fa.load_graph({"format": "flowabs.graph/1", "name": "absent", "nodes": nodes})


@pytest.mark.parametrize("what", ["beauty", "other"])
def test_in_place_of_an_absent_pass_nothing_is_read_and_that_is_told(tmp_path: Path, what: str) -> None:
    channels = planes(colors(dtype=np.float32))
    if what == "other":
        channels |= {"Z": renders.depth()}
    path = exr(tmp_path / "a.exr", channels, dataWindow=box(3, 1, 32, 24))
    said: list[dict[str, Any]] = []
    made = absent_graph(path).run(outputs=["normal", "ids", "ids.coverage"], on_event=said.append)
    assert not made["normal"].pixels.any()
    assert not made["ids"].pixels.any()
    assert (made["ids.coverage"].pixels == 1).all()
    assert {(image.type, image.data_window) for image in made.values()} == {
        (type, (3, 1, 32, 24)) for type in ("normal", "id", "mono")
    }
    warnings = {each["node"]: each["text"] for each in said if each["level"] == "warning"}
    assert warnings.keys() == {"normal", "ids"}
    assert all(each.startswith("nothing is read: ") for each in warnings.values())


@pytest.mark.parametrize(
    ("params", "code"),
    [({"layer": "N"}, "wrong-layer"), ({"absent": "error"}, "no-layer"), ({"layer": "nromal"}, "unknown-layer")],
)
def test_what_else_is_wrong_with_a_pass_is_an_error_all_the_same(
    tmp_path: Path, params: dict[str, str], code: str
) -> None:
    path = exr(tmp_path / "a.exr", {"N": renders.depth(), "Y": renders.depth()})
    with pytest.raises(fa.FlowabsError) as caught:
        absent_graph(path, **params).run(outputs="normal")
    assert caught.value.code == code


def test_of_a_pass_that_few_renders_have_there_is_a_note_and_no_warning(tmp_path: Path) -> None:
    said: list[dict[str, Any]] = []
    graph = absent_graph(exr(tmp_path / "a.exr", planes(colors())), absent="optional")
    assert not graph.run(outputs="ids", on_event=said.append)["ids"].pixels.any()
    told = [(each["level"], each["text"]) for each in said if each["node"] == "ids"]
    why = "no ids in the file: in its only layer, R, G, B, each pixel has several numbers"
    assert told == [("note", f"nothing is read: {why}")]
