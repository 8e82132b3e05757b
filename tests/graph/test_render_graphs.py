"""The graphs for renders with passes and for shots: toon, outline, steady_lines, steady_abstraction.

On three small frames of Blender 4.5 and 5.2 with every kind of edge (tools/blender/passes_shot.py).
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa
from flowabs_nodes.engine.runnable import RunnableGraph
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.image import Image
from tests.io.files import exr, planes

DATA = Path(__file__).parents[1] / "data" / "blender"
SHOTS = {version: str(DATA / f"passes_{version}.####.exr") for version in ("45", "52")}
PASSES = ("toon", "outline")
STEADY = ("toon", "steady_lines", "steady_abstraction")


def loaded(name: str, version: str = "52", size: int = 54, **values: Any) -> RunnableGraph:
    """Return a graph on a shot, its lengths meant for pictures of ``size``."""
    document = json.loads(shipped()[name].read_text(encoding="utf-8"))
    document["reference_size"] = {"shorter": size}
    return fa.load_graph(document).with_set({"plate.file": SHOTS[version], **values})


def made(graph: RunnableGraph, output: str, frame: int = 2) -> Image:
    return graph.run(frame, outputs=output, on_event=lambda event: None)[output]


def ink(graph: RunnableGraph, output: str = "pens.lines", frame: int = 2) -> np.ndarray:
    """Return how much of each pixel is ink."""
    return 1 - made(graph, output, frame).pixels[..., 0]


@pytest.mark.parametrize("version", SHOTS)
def test_outlines_lie_where_things_are(version: str) -> None:
    lines = ink(loaded("outline", version, outline_width=1, object_width=1, inner_width=1))
    assert 0.05 < lines.mean() < 0.15
    assert (lines[18:22, :12].max(axis=0) > 0.8).all(), "the horizon"
    assert lines[:12].max() < 0.02, "the sky"
    assert lines[45:, 75:].max() < 0.05, "the floor"


def test_both_versions_of_blender_have_the_same_lines() -> None:
    one, other = (ink(loaded("outline", version)) for version in SHOTS)
    assert np.abs(one - other).mean() < 0.01


@pytest.mark.parametrize(
    ("knob", "kinds"),
    [
        ({"outline_width": 0}, "outline"),
        ({"object_width": 0}, "object"),
        ({"inner_width": 0}, "material crease intersection"),
        ({"crease_amount": 0}, "crease"),
    ],
)
def test_each_kind_of_line_has_a_knob(knob: dict[str, float], kinds: str) -> None:
    """Ink that a knob takes away was of its kinds."""
    drawn = loaded("outline", taper=0)
    gone = ink(drawn) - ink(drawn.with_set(knob))
    mattes = [made(drawn, f"edges.{kind}").pixels[..., 0] for kind in kinds.split()]
    assert gone.sum() > 5
    assert gone[np.max(mattes, axis=0) == 0].sum() < 0.1 * gone.sum()


def test_ink_over_the_render_and_over_nothing() -> None:
    drawn = loaded("outline", outline_ink=[1, 0, 0], inner_ink=[0, 0, 1])
    over, alone, plate = made(drawn, "comp"), made(drawn.with_set({"over_plate": 0}), "comp"), made(drawn, "plate")
    assert alone.pixels.shape[2] == 4
    expected = alone.pixels[..., :3] + plate.pixels[..., :3] * (1 - alone.pixels[..., 3:])
    np.testing.assert_allclose(over.pixels[..., :3], expected, atol=1e-5)
    assert alone.pixels[..., 0].max() > 0.9
    assert alone.pixels[..., 2].max() > 0.9


def test_toon_joins_lines_of_passes_with_those_of_light() -> None:
    toon = loaded("toon", outline_width=1)
    outlines, none = ink(toon), ink(toon.with_set({"inner_detail": 0}), "lines")
    np.testing.assert_allclose(none, outlines, atol=1e-6)
    detailed = ink(toon.with_set({"inner_detail": 1}), "lines")
    assert (detailed >= outlines - 1e-6).all()
    assert (detailed - outlines).sum() > 5


def test_boil_moves_the_ink_of_toon_and_is_off() -> None:
    toon = loaded("toon", inner_detail=0)
    np.testing.assert_array_equal(ink(toon, "lines"), ink(toon, "joined"))
    boiling = toon.with_set({"boil": 2})
    moved = ink(boiling, "lines")
    assert np.abs(moved - ink(toon, "lines")).mean() > 0.005
    assert moved.sum() == pytest.approx(ink(toon, "lines").sum(), rel=0.15)
    np.testing.assert_array_equal(ink(boiling.with_set({"boil_hold": 6}), "lines"), moved)  # frames 1 to 6


@pytest.mark.parametrize("name", STEADY)
def test_steadiness_reads_other_frames(name: str) -> None:
    if name != "toon":
        pytest.importorskip("cv2")
    graph = loaded(name)
    steady, alone = made(graph, "steady"), made(graph.with_set({"steadiness": 0}), "steady")
    plate = made(graph, "plate")
    np.testing.assert_array_equal(alone.pixels, plate.pixels)
    assert not np.array_equal(steady.pixels, plate.pixels)
    assert np.abs(steady.pixels - plate.pixels).mean() < 0.02


def test_toon_without_a_motion_pass_follows_the_picture(tmp_path: Path) -> None:
    pytest.importorskip("cv2")
    toon = loaded("toon").with_set({"plate.file": without(tmp_path, "Vector"), "motion_from": 1})
    assert made(toon, "comp").pixels.std() > 0.05


def test_toon_frame_by_frame_needs_no_motion(tmp_path: Path) -> None:
    toon = loaded("toon").with_set({"plate.file": without(tmp_path, "Vector"), "steadiness": 0})
    assert made(toon, "comp").pixels.std() > 0.05


# ---------------------------------------------------------------------- what a render may lack


def without(tmp_path: Path, *passes: str) -> str:
    """Write a frame of the shot without some passes, with plain names; return its file."""
    wanted = {"Combined": "RGB", "Depth": "Z", "Normal": "XYZ", "Vector": "XYZW"}
    channels = {}
    for name, letters in wanted.items():
        if name in passes:
            continue
        part = next(
            index
            for index in range(9)
            if oiio.ImageBuf(str(DATA / "passes_52.0002.exr"), index, 0)
            .spec()
            .channelnames[0]
            .startswith(f"ViewLayer.{name}.")
        )
        pixels = oiio.ImageBuf(str(DATA / "passes_52.0002.exr"), part, 0).get_pixels(oiio.FLOAT)
        channels |= planes(
            np.ascontiguousarray(pixels[..., : len(letters)]), letters, "" if name == "Combined" else name
        )
    return str(exr(tmp_path / "render.0002.exr", channels))


def test_without_ids_materials_and_normals_lines_come_from_depth(tmp_path: Path) -> None:
    said: list[dict[str, Any]] = []
    graph = loaded("outline").with_set({"plate.file": without(tmp_path, "Normal")})
    lines = 1 - graph.run(2, outputs="pens.lines", on_event=said.append)["pens.lines"].pixels[..., 0]
    assert (lines[18:22, :12].max(axis=0) > 0.5).all(), "the horizon"
    told = {each["node"]: each["level"] for each in said if each["text"].startswith("nothing is read")}
    assert told == {"normal": "warning", "ids": "warning", "materials": "note"}


@pytest.mark.parametrize(
    ("lacks", "node", "message"),
    [
        ("Depth", "depth", "no layer with a usual name for depth"),
        ("Vector", "pass_motion", "no layer with a usual name for motion"),
    ],
)
def test_a_pass_that_toon_cannot_do_without_is_named(tmp_path: Path, lacks: str, node: str, message: str) -> None:
    graph = loaded("toon").with_set({"plate.file": without(tmp_path, lacks)})
    with pytest.raises(fa.FlowabsError, match=message) as caught:
        made(graph, "comp")
    assert caught.value.node == node


def test_passes_in_files_of_their_own(tmp_path: Path) -> None:
    """Of any name and channel names; here normals are R, G, B and depth Y."""
    from flowabs_nodes.io.read_passes import read_depth, read_normal

    for frame in (1, 2, 3):
        source = DATA / f"passes_52.{frame:04d}.exr"
        exr(tmp_path / f"n.{frame:04d}.exr", planes(read_normal(source).pixels))
        exr(tmp_path / f"z.{frame:04d}.exr", {"Y": read_depth(source).pixels[..., 0]})
    own = {"normal.file": str(tmp_path / "n.####.exr"), "depth.file": str(tmp_path / "z.####.exr")}
    np.testing.assert_array_equal(ink(loaded("outline", **own)), ink(loaded("outline")))


@pytest.mark.parametrize("name", PASSES)
def test_passes_of_another_size_are_an_error(name: str, tmp_path: Path) -> None:
    small = exr(tmp_path / "z.0002.exr", {"Z": np.ones((20, 30), np.float32)})
    with pytest.raises(fa.FlowabsError, match=r"96x54.*30x20|30x20.*96x54"):
        made(loaded(name, **{"depth.file": str(small)}), "pens.lines")


@pytest.mark.parametrize(("convention", "warned"), [("auto", False), ("forward", True)])
def test_motion_in_another_convention_is_told(convention: str, warned: bool) -> None:
    said: list[dict[str, Any]] = []
    toon = loaded("toon", **{"pass_motion.convention": convention})
    toon.run(2, outputs="window", on_event=said.append)
    warnings = [each["text"] for each in said if each["level"] == "warning"]
    assert any("convention" in each for each in warnings) == warned


@pytest.mark.parametrize("name", PASSES)
def test_a_plate_without_any_pass_is_an_error_that_says_so(name: str, tmp_path: Path) -> None:
    plate = exr(tmp_path / "plate.exr", planes(np.random.default_rng(1).random((54, 96, 3), np.float32)))
    with pytest.raises(fa.FlowabsError, match="no depth in the file: in its only layer, R, G, B") as caught:
        made(loaded(name).with_set({"plate.file": str(plate)}), "comp", 1)
    assert caught.value.node == "depth"


def test_nan_and_an_empty_scene_do_no_harm(tmp_path: Path) -> None:
    broken, empty = np.full((54, 96), np.nan, np.float32), np.full((54, 96), 1e10, np.float32)
    for depth in (broken, empty):
        file = exr(tmp_path / "z.0002.exr", {"Z": depth})
        lines = ink(loaded("outline", **{"depth.file": str(file)}))
        assert np.isfinite(lines).all()


# ---------------------------------------------------------------------- runs


@pytest.mark.slow
@pytest.mark.parametrize("name", STEADY)
def test_by_frame_by_chunk_and_in_parallel_files_are_identical(name: str, tmp_path: Path) -> None:
    if name != "toon":
        pytest.importorskip("cv2")

    def run(folder: str, **options: Any) -> None:
        out = tmp_path / folder / "out.####.exr"
        assert fa.run(name, input=SHOTS["52"], output=out, **options).exit_code == 0

    run("whole")
    run("parallel", jobs=2)
    for frame in (3, 1, 2):
        run("frames", frames=frame)
    for frame in (1, 2, 3):
        first, *others = (
            oiio.ImageBuf(str(tmp_path / folder / f"out.{frame:04d}.exr")).get_pixels()
            for folder in ("whole", "parallel", "frames")
        )
        assert all(np.array_equal(first, other) for other in others)


@pytest.mark.parametrize("name", PASSES)
def test_a_shot_with_a_hole(name: str, tmp_path: Path) -> None:
    for frame in (1, 3):
        shutil.copy(DATA / f"passes_52.{frame:04d}.exr", tmp_path / f"shot.{frame:04d}.exr")
    shot = str(tmp_path / "shot.####.exr")
    report = fa.run(name, input=shot, output=tmp_path / "out.####.exr", frames="1-3", missing="skip")
    assert {frame.frame: frame.status for frame in report.frames} == {1: "done", 2: "skipped", 3: "done"}
