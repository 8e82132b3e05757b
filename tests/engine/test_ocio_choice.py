"""Which OCIO config a run uses, and that frames are made again when its content changes, and only then."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.color.config import PINNED
from flowabs_nodes.engine.keys import node_key
from flowabs_nodes.engine.ocio_choice import choose_config
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import ColorError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import stored_key
from flowabs_nodes.nodes.declare import Node, Param, Port
from tests.engine.sequences import document, pixels, plate, run, statuses
from tests.studio import STUDIO, studio, table

RGB = np.random.default_rng(1).random((6, 8, 3), np.float32)


@pytest.fixture
def show(tmp_path, monkeypatch):
    path = studio(tmp_path / "show")
    monkeypatch.setenv("OCIO", path)
    return path


def colour_notes(report):
    return [note.text for note in report.notes if note.text.startswith("colour config")]


def graph(space="show_log", to="plate"):
    """Return plate -> bright -> out, read as ``space`` and written as ``to``."""
    return document(
        plate={"type": "read@1", "params": {"colorspace": space}},
        out={"type": "write@1", "inputs": {"image": "bright"}, "params": {"colorspace": to}},
    )


def test_the_environment_is_honoured_and_said(show, tmp_path):
    out = tmp_path / "out.exr"
    report = run(plate(tmp_path / "in.exr"), out, graph=graph(), set={"stops": 0})
    assert statuses(report) == [(1, "done")]
    assert colour_notes(report) == [f"colour config {show}, from $OCIO"]
    np.testing.assert_allclose(pixels(out), 10.0 ** pixels(tmp_path / "in.exr"), rtol=3e-3)


def test_the_option_goes_before_the_environment(show, tmp_path, monkeypatch):
    other = studio(tmp_path / "other", text=STUDIO.replace("base: 10", "base: 2"))
    out = tmp_path / "out.exr"
    report = run(plate(tmp_path / "in.exr"), out, graph=graph(), set={"stops": 0}, ocio=other)
    assert colour_notes(report) == [f"colour config {other}, from the option ocio, which goes before $OCIO"]
    np.testing.assert_allclose(pixels(out), 2.0 ** pixels(tmp_path / "in.exr"), rtol=3e-3)
    monkeypatch.setenv("OCIO", "/no/such.ocio")  # nobody asks it
    assert statuses(run(tmp_path / "in.exr", tmp_path / "b.exr", graph=graph(), ocio=other)) == [(1, "done")]


def test_without_both_it_is_the_pinned_one_and_nothing_is_said(tmp_path, monkeypatch):
    monkeypatch.setenv("OCIO", "")
    report = run(plate(tmp_path / "in.exr"), tmp_path / "out.exr", graph=graph("ACEScct"))
    assert statuses(report) == [(1, "done")]
    assert colour_notes(report) == []


@pytest.mark.parametrize("source", ["option", "environment"])
@pytest.mark.parametrize("kind", ["missing", "broken", "folder", "unknown"])
def test_a_config_that_cannot_be_read_is_fatal(tmp_path, monkeypatch, source, kind):
    path = tmp_path / "studio.ocio"
    if kind == "broken":
        path.write_text("ocio_profile_version: 2\nroles: {")
    elif kind == "folder":
        path.mkdir()
    name = "ocio://no-such-config" if kind == "unknown" else str(path)
    if source == "environment":
        monkeypatch.setenv("OCIO", name)
    ocio = name if source == "option" else None
    out = tmp_path / "out.exr"
    with pytest.raises(ColorError, match="cannot be read") as caught:
        run(plate(tmp_path / "in.exr"), out, ocio=ocio)
    assert name in str(caught.value)
    assert ("$OCIO" in caught.value.hint) == (source == "environment")
    assert not out.exists()
    with pytest.raises(ColorError, match="cannot be read"):
        fa.load_graph(document()).run(
            given={"plate": fa.Image.from_array(RGB)}, outputs="bright", settings=Settings(ocio=ocio)
        )


def test_a_built_in_config_by_name(tmp_path):
    name = "ocio://cg-config-v2.2.0_aces-v1.3_ocio-v2.4"
    report = run(plate(tmp_path / "in.exr"), tmp_path / "out.exr", graph=graph("ACEScct"), ocio=name)
    assert statuses(report) == [(1, "done")]
    assert colour_notes(report) == [f"colour config {name}, from the option ocio"]


def key(folder, ocio, **how):
    out = folder / "keyed.exr"
    report = run(folder / "in.exr", out, ocio=ocio, existing="overwrite", **how)
    assert statuses(report) == [(1, "done")]
    return stored_key(out)


def test_the_pinned_config_by_its_name_is_the_same(tmp_path):
    plate(tmp_path / "in.exr")
    assert key(tmp_path, None) == key(tmp_path, PINNED)


def test_the_content_is_a_part_of_the_key(tmp_path):
    plate(tmp_path / "in.exr")
    path = studio(tmp_path / "show")
    first = key(tmp_path, path, graph=graph())
    assert first != key(tmp_path, None, graph=graph("ACEScct"))
    shutil.copytree(tmp_path / "show", tmp_path / "elsewhere")
    assert key(tmp_path, str(tmp_path / "elsewhere/config.ocio"), graph=graph()) == first
    studio(tmp_path / "show", text=STUDIO + "# edited\n")
    assert key(tmp_path, path, graph=graph()) != first


def test_an_edited_table_makes_frames_again_with_its_new_colours(show, tmp_path):
    source, out = plate(tmp_path / "in.exr"), tmp_path / "out.exr"
    how = {"graph": graph("show_film"), "set": {"stops": 0}}
    assert statuses(run(source, out, **how)) == [(1, "done")]
    assert statuses(run(source, out, **how)) == [(1, "skipped")]
    table(tmp_path / "show", 2.0)
    assert statuses(run(source, out, **how)) == [(1, "done")]
    np.testing.assert_allclose(pixels(out), 2 * pixels(source), rtol=3e-3)
    shutil.move(tmp_path / "show", tmp_path / "moved")
    assert statuses(run(source, out, ocio=str(tmp_path / "moved/config.ocio"), **how)) == [(1, "skipped")]


def test_our_names_work_under_it(show, tmp_path):
    source = plate(tmp_path / "in.exr")
    for space in ("lin_rec709", "acescg", "ACEScg", "sRGB - Texture"):
        out = tmp_path / "out.exr"
        report = run(source, out, graph=graph(space, "show_lin"), set={"stops": 0}, existing="overwrite")
        assert statuses(report) == [(1, "done")], report.frames[0].error


def test_a_space_without_a_way_to_ours_is_refused_before_the_first_frame(tmp_path):
    path = studio(tmp_path / "show", interchange="")
    source = plate(tmp_path / "in.exr")
    with pytest.raises(GraphError, match="no interchange role") as caught:
        run(source, tmp_path / "out.exr", graph=graph(), ocio=path)
    assert caught.value.problems[0].pointer == "/nodes/plate/params/colorspace"
    assert statuses(run(source, tmp_path / "out.exr", graph=graph("lin_rec709"), ocio=path)) == [(1, "done")]


def test_a_missing_table_is_named(tmp_path):
    path = studio(tmp_path / "show", gain=None)
    with pytest.raises(GraphError, match=r"film\.cube"):
        run(plate(tmp_path / "in.exr"), tmp_path / "out.exr", graph=graph("show_film"), ocio=path)
    assert statuses(run(tmp_path / "in.exr", tmp_path / "out.exr", graph=graph("show_log"), ocio=path)) == [(1, "done")]


def test_graph_run_has_the_same_rules(show, tmp_path, monkeypatch):
    loaded = fa.load_graph(graph()).with_set({"plate.file": str(plate(tmp_path / "in.exr"))})
    told = []
    image = loaded.run(outputs="plate", on_event=told.append)["plate"]
    np.testing.assert_allclose(image.pixels, 10.0 ** pixels(tmp_path / "in.exr"), rtol=1e-3)
    assert [each["text"] for each in told if "config" in each["text"]] == [f"colour config {show}, from $OCIO"]
    other = studio(tmp_path / "other", text=STUDIO.replace("base: 10", "base: 2"))
    image = loaded.run(outputs="plate", settings=Settings(ocio=other))["plate"]
    np.testing.assert_allclose(image.pixels, 2.0 ** pixels(tmp_path / "in.exr"), rtol=1e-3)
    monkeypatch.delenv("OCIO")
    with pytest.raises(ColorError, match="has no colour space 'show_log'") as caught:
        loaded.run(outputs="plate")
    assert (caught.value.node, caught.value.frame) == ("plate", 1)


def test_the_environment_is_read_at_each_call(monkeypatch, tmp_path):
    for name in ("a", "b"):
        path = studio(tmp_path / name)
        monkeypatch.setenv("OCIO", path)
        assert choose_config(RunOptions())[0].ocio == path
    monkeypatch.delenv("OCIO")
    assert choose_config(RunOptions()) == (RunOptions(), ())


def huge(folder, value=65504.0):
    path = folder / "huge.exr"
    pixels = np.full((6, 8, 3), 0.25, np.float32)
    pixels[2, 3] = pixels[4, 5] = value
    buf = fa.Image.from_array(pixels).to_imagebuf()
    assert buf.write(str(path), "float")
    return path


@pytest.mark.parametrize("space", ["ACEScct", "ARRI LogC4", "cineon", "show_log"])
def test_a_plate_that_becomes_infinite_by_its_space(space, tmp_path):
    path = huge(tmp_path)
    ocio = studio(tmp_path / "show") if space == "show_log" else None
    report = run(path, tmp_path / "out.exr", graph=graph(space), ocio=ocio)
    error = report.frames[0].error
    assert report.exit_code == 1
    assert (error.node, error.file, error.frame, error.code) == ("plate", str(path), 1, "non-finite")
    assert f"decoded from {space!r}, 2 pixels become NaN or Inf, the first at x 3, y 2: 65504" in str(error)
    assert not (tmp_path / "out.exr").exists()


@pytest.mark.parametrize("name", ["out.exr", "out.png", "out.tif"])
def test_a_picture_that_becomes_infinite_by_the_space_it_is_written_in(name, tmp_path):
    out = tmp_path / name
    source = huge(tmp_path, (3e38, -3e38, 0))
    report = run(source, out, graph=graph("lin_rec709", "lin_p3d65_scene"), set={"stops": 0})
    error = report.frames[0].error
    assert report.exit_code == 1
    assert (error.node, error.file, error.code) == ("out", str(out), "non-finite")
    assert "lin_p3d65_scene" in error.message.split(",")[0]  # by the ICC profile made of it, where the file holds one
    assert "2 pixels become NaN or Inf, the first at x 3, y 2: 3e+38 -3e+38 0" in error.message
    assert not out.exists()


def test_a_node_that_names_a_space_has_the_config_in_its_key():
    port = Port("image", "color", "A picture.")
    plain, naming = (
        Node("look", 1, "A test's own.", (port,), (Port("image", "=image", "The result."),), (space,), lambda: None)
        for space in (
            Param.string("space", "aces", help="A word."),
            Param.string("space", "aces", colorspace=(), help="A space."),
        )
    )
    for declaration, differs in ((plain, False), (naming, True)):
        first, second = (node_key(declaration, {"space": "a"}, {}, ocio=content) for content in ("", "content"))
        assert (first != second) == differs
    assert node_key(plain, {"space": "a"}, {}) == node_key(naming, {"space": "a"}, {})


def test_a_path_is_a_name(tmp_path):
    path = Path(studio(tmp_path / "show"))
    report = run(plate(tmp_path / "in.exr"), tmp_path / "out.exr", graph=graph(), ocio=path)
    assert statuses(report) == [(1, "done")]
    assert read_image(tmp_path / "in.exr", colorspace="show_lin", settings=Settings(ocio=path)).colorspace.name == (
        "lin_ap1_scene"
    )
