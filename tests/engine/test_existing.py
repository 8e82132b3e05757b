"""What a run does with files that are there: its own stay or are made again, all others are left alone."""

import os

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import engine
from flowabs_nodes.image import Image
from flowabs_nodes.io.write import build_picture, save
from tests.engine.sequences import codes, document, run, statuses


def of_020(path, key="of another run", graph='{"name": "bright"}'):
    """Write a file as version 0.2.0 stamped it: with key and graph alone."""
    path.parent.mkdir(exist_ok=True)
    buf = Image.from_array(np.ones((8, 8, 3), np.float32)).to_imagebuf()
    buf.specmod().attribute("flowabs:key", key)
    buf.specmod().attribute("flowabs:graph", graph)
    assert buf.write(str(path), "half"), buf.geterror()
    return path


def key_in(path):
    return oiio.ImageBuf(str(path)).spec().get_string_attribute("flowabs:key")


def refused(report, out, *words):
    """Say that frame 1 failed because of a file that is not this run's, and that the cure is named."""
    assert codes(report) == {1: "foreign-file"}
    text = str(report.frames[0].error)
    assert all(word in text for word in (*words, out.replace("####", "0001"), "--existing overwrite")), text
    return True


def test_a_file_of_another_graph_is_left_alone(shot, out):
    run(shot, out, frames=1)
    before = key_in(out.replace("####", "0001"))
    other = document() | {"name": "lines"}
    assert statuses(run(shot, out, other, frames=1)) == [(1, "skipped")], "the same picture, whatever it is called"
    assert refused(
        run(shot, out, other, frames=1, set={"stops": 2.0}), out, "the graph 'bright', not by the graph 'lines'"
    )
    assert key_in(out.replace("####", "0001")) == before
    assert statuses(run(shot, out, other, frames=1, set={"stops": 2.0}, existing="overwrite")) == [(1, "done")]


def test_graphs_without_a_name_count_as_one(shot, out):
    unnamed = {name: value for name, value in document().items() if name != "name"}
    assert statuses(run(shot, out, unnamed, frames=1)) == [(1, "done")]
    assert statuses(run(shot, out, unnamed, frames=1, set={"stops": 2.0})) == [(1, "done")]
    assert refused(run(shot, out, frames=1), out, "a graph without a name, not by the graph 'bright'")


def test_a_full_size_file_is_not_replaced_by_a_preview(shot, out):
    run(shot, out, frames=1)
    assert refused(run(shot, out, frames=1, scale=0.5), out, "--scale 1, not 0.5")
    assert statuses(run(shot, out, frames=1, scale=0.5, existing="overwrite")) == [(1, "done")]
    assert refused(run(shot, out, frames=1), out, "--scale 0.5, not 1")
    assert statuses(run(shot, out, frames=1, scale=0.5)) == [(1, "skipped")]


@pytest.mark.parametrize("name", ["toon.####.exr", "toon.####.png", "toon.####.tif"])
def test_every_format_tells_graph_and_scale(shot, tmp_path, name):
    out = str(tmp_path / "out" / name)
    run(shot, out, frames=1)
    assert refused(run(shot, out, frames=1, scale=0.5), out, "--scale 1")
    assert refused(run(shot, out, document() | {"name": "x"}, frames=1, set={"stops": 3.0}), out, "'bright'")


def test_files_of_0_2_0_are_known(shot, out, tmp_path):
    path = of_020(tmp_path / "out/toon.0001.exr")
    assert statuses(run(shot, out, frames=1)) == [(1, "done")]
    of_020(path, key_in(path))
    assert statuses(run(shot, out, frames=1)) == [(1, "skipped")]
    of_020(path, graph='{"name": "lines"}')
    assert refused(run(shot, out, frames=1), out, "'lines'")
    for unreadable in ("", "{", "[1]", '{"name": 3}'):
        of_020(path, graph=unreadable)
        assert statuses(run(shot, out, frames=1)) == [(1, "done")], "it does not say its graph"


def test_a_file_without_a_key(shot, out, tmp_path):
    path = tmp_path / "out/toon.0001.exr"
    save(build_picture(Image.from_array(np.ones((8, 8, 3), np.float32))), path)
    assert refused(run(shot, out, frames=1), out, "not written by flowabs")


@pytest.mark.parametrize(("name", "size"), [("toon.####.exr", 300), ("toon.####.png", 30), ("toon.####.tif", 9000)])
def test_our_own_cut_short_in_its_header_names_the_cure(shot, tmp_path, name, size):
    out = str(tmp_path / "out" / name)
    run(shot, out, frames=1)
    path = out.replace("####", "0001")
    size = min(size, os.path.getsize(path) - 1)
    os.truncate(path, size)
    assert refused(run(shot, out, frames=1), out, "cut short in its header")
    assert os.path.getsize(path) == size
    assert statuses(run(shot, out, frames=1, existing="overwrite")) == [(1, "done")]


@pytest.mark.parametrize("compression", ["none", "piz", "dwaa"])
def test_a_changed_pixel_is_made_again_and_said(shot, out, compression):
    graph = document(
        out={"type": "write@1", "inputs": {"image": "bright"}, "params": {"compression": compression}},
    )
    run(shot, out, graph, frames=1)
    path = out.replace("####", "0001")
    with open(path, "r+b") as file:
        whole = file.read()
        file.seek(-5, os.SEEK_END)
        file.write(bytes([whole[-5] ^ 1]))
    report = run(shot, out, graph, frames=1)
    assert statuses(report) == [(1, "done")]
    assert any(
        "has other pixels than were written" in note.text or "damaged" in note.text for note in report.frames[0].notes
    )
    with open(path, "rb") as file:
        assert file.read() == whole
    assert statuses(run(shot, out, graph, frames=1)) == [(1, "skipped")]


@pytest.mark.parametrize("existing", ["resume", "overwrite", "error"])
def test_pipes_and_devices_are_named_and_never_opened(shot, out, tmp_path, existing):
    (tmp_path / "out").mkdir()
    os.mkfifo(tmp_path / "out/toon.0001.exr")
    report = run(shot, out, frames="1-2", existing=existing)
    assert codes(report) == {1: "not-a-file"}
    assert "a pipe" in str(report.frames[0].error)
    assert statuses(report)[1] == (2, "done")


def test_a_graph_from_a_file_resumes_as_one_from_a_dict(shot, out):
    run(shot, out, frames=1)
    loaded = engine.load_graph(document())
    assert statuses(run(shot, out, loaded, frames=1)) == [(1, "skipped")]
