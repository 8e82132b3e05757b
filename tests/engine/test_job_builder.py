"""Jobs: how small they are, and which commands are refused before anything is written."""

import os
import pickle
import time
from dataclasses import replace

import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine import sources
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.io.settings import Settings
from tests.engine.sequences import document, plate


def test_a_job_is_small_however_many_frames_there_are_and_holds_every_rule(shot, out):
    rules = {"existing": "overwrite", "missing": "hold", "scale": 0.5, "max_pixels": 10_000}
    options = RunOptions(input=shot, output=out, frames=range(1, 10_001), set={"stops": 2}, **rules)
    job, frames = build_job(engine.load_graph(document()).with_set(options.set), options)
    assert len(frames) == 10_000
    assert len(pickle.dumps(job)) < 2000
    assert pickle.loads(pickle.dumps(job)).options == RunOptions(**rules)


@pytest.mark.parametrize(
    ("options", "code"),
    [
        ({"output": None}, "file-not-set"),
        ({"input": None}, "file-not-set"),
        ({"output": "{tmp}/one.exr"}, "no-frame-token"),
        ({"output": ["{tmp}/a.####.exr", "{tmp}/a.####.exr"]}, "same-output"),
        ({"output": "{tmp}/in/plate.####.exr"}, "output-is-input"),
        ({"output": "{tmp}/in/../in/plate.%04d.exr"}, "output-is-input"),
        ({"output": "{tmp}/link.####.exr", "frames": "9"}, "output-is-input"),
        ({"output": "{tmp}/a.####.jpg"}, "bad-format"),
        ({"output": "{tmp}/in/plate.0001.exr/x.####.exr"}, "unwritable-folder"),
        ({"output": "/proc/1/nothing/x.####.exr"}, "unwritable-folder"),
        ({"frames": "1-"}, "bad-frames"),
        ({"frames": []}, "bad-frames"),
        ({"frames": [1, 2.5]}, "bad-frames"),
        ({"input": "{tmp}/none.####.exr"}, "no-frames"),
        ({"input": "{tmp}/in/plate.####.####.exr"}, "bad-sequence"),
        ({"existing": "keep"}, "bad-value"),
        ({"missing": "hole"}, "bad-value"),
        ({"scale": 0}, "bad-value"),
        ({"settings": Settings(root="{tmp}/in")}, "outside-root"),
        ({"settings": Settings(ocio="no/such.ocio")}, "bad-ocio-config"),
        ({"graph": "abstractoin"}, "unknown-graph"),
        ({"set": {"stop": 1}}, "bad-graph"),
    ],
)
def test_wrong_commands(shot, out, tmp_path, options, code):
    (tmp_path / "link.0009.exr").symlink_to(tmp_path / "in/plate.0002.exr")

    def placed(value):
        if isinstance(value, Settings):
            return replace(value, root=value.root and tmp_path / "in")
        if isinstance(value, list):
            return [placed(each) for each in value]
        return value.replace("{tmp}", str(tmp_path)) if isinstance(value, str) else value

    options = {"graph": document(), "input": shot, "output": out} | {
        name: placed(each) for name, each in options.items()
    }
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(FlowabsError) as failure:
        engine.run(options.pop("graph"), **options)
    assert failure.value.code == code
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    ("nodes", "option", "code"),
    [
        ({"second": {"type": "read@1"}}, "input", "several-reads"),
        ({"second": {"type": "write@1", "inputs": {"image": "plate"}}}, "output", "several-writes"),
    ],
)
def test_with_several_reads_or_writes_the_node_must_be_named(shot, nodes, option, code):
    with pytest.raises(CommandError, match=r"--set .*\.file=FILE") as failure:
        engine.run(document(**nodes), **{option: shot})
    assert failure.value.code == code


def test_a_graph_that_writes_nothing(shot):
    graph = document()
    del graph["nodes"]["out"]
    with pytest.raises(CommandError) as failure:
        engine.run(graph, input=shot)
    assert failure.value.code == "no-write"


@pytest.mark.parametrize("kind", ["movie", "device", "pipe", "folder", "link", "png", "huge", "text_name"])
def test_what_is_no_picture_is_refused_before_it_is_read(tmp_path, out, kind):
    path = tmp_path / ("clip.mov" if kind in ("movie", "text_name") else "in.exr")
    if kind == "movie":
        with path.open("wb") as file:
            file.truncate(3 * 2**30)
    elif kind == "huge":
        path = tmp_path / "huge.mp4"
        with path.open("wb") as file:
            file.truncate(2**40)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "link":
        path.symlink_to(tmp_path)
    elif kind == "png":
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"\0" * 100)
    start = time.perf_counter()
    with pytest.raises(CommandError) as caught:
        engine.run(document(), input=str(path), output=out.replace("####", "0001"))
    assert time.perf_counter() - start < 5
    assert caught.value.code in ("bad-format", "not-a-file")
    assert caught.value.file == str(path)


def test_a_sequence_of_no_picture_format_is_a_wrong_command(tmp_path, out):
    with pytest.raises(CommandError, match="not a picture format"):
        engine.run(document(), input=str(tmp_path / "clip.####.mov"), output=out, frames="1-3")


def test_one_frame_that_is_no_picture_fails_alone(shot, out, tmp_path):
    (tmp_path / "in/plate.0002.exr").unlink()
    (tmp_path / "in/plate.0002.exr").symlink_to("/dev/zero")
    report = engine.run(document(), input=shot, output=out)
    assert report.exit_code == 1
    assert [each.status for each in report.frames] == ["done", "failed", "done"]
    assert "a device" in str(report.frames[1].error)


def test_a_picture_that_is_too_large_is_not_hashed(tmp_path, out, monkeypatch):
    path = plate(tmp_path / "in.exr")
    monkeypatch.setattr(sources, "content_hash", lambda path: pytest.fail("read"))
    report = engine.run(document(), input=str(path), output=out, frames="1", max_pixels=100)
    assert report.frames[0].error.code == "too-large"


def test_files_passed_over_are_told_in_one_line(shot, out, tmp_path):
    for name in ("plate.7.exr", "plate.00008.exr"):
        plate(tmp_path / "in" / name)
    events = []
    report = engine.run(document(), input=shot, output=out, on_event=events.append)
    told = [each for each in events if "plate.00008.exr, plate.7.exr" in str(each)]
    assert len(told) == 1
    assert len(report.frames) == 3


@pytest.mark.parametrize(
    ("source", "frames", "told"),
    [
        ("one.exr", "1-3", ["all 3 frames come from one picture, one.exr: a sequence has a token, such as ####"]),
        ("take#2.exr", "5,9", ["all 2 frames come from one picture, take#2.exr: a sequence has a token, such as ####"]),
        ("one.exr", "2-2", []),
        ("one.exr", None, []),
        ("plate.####.exr", "1-3", []),
    ],
)
def test_frames_that_all_come_from_one_picture_are_told(shot, out, tmp_path, source, frames, told):
    for name in ("one.exr", "take#2.exr"):
        plate(tmp_path / "in" / name)
    events = []
    report = engine.run(
        document(), input=str(tmp_path / "in" / source), output=out, frames=frames, on_event=events.append
    )
    assert report.exit_code == 0
    assert [event["text"] for event in events if "come from" in str(event)] == told


def test_several_single_pictures_are_told_together_and_not_beside_a_sequence(shot, out, tmp_path):
    two = document()
    two["nodes"]["still"] = {"type": "read@1", "params": {"file": plate(tmp_path / "in" / "still.exr").as_posix()}}
    two["nodes"]["out"]["inputs"]["beside"] = "still"
    one = plate(tmp_path / "in" / "one.exr")
    for source, told in ((one, ["all 2 frames come from 2 pictures, "]), (shot, [])):
        events = []
        engine.run(
            two, set={"plate.file": str(source)}, output=out, frames="1-2", existing="overwrite", on_event=events.append
        )
        assert [event["text"][:35] for event in events if "come from" in str(event)] == told


def test_a_name_that_looks_like_a_sequence(tmp_path):
    path = plate(tmp_path / "take#2.exr")
    report = engine.run(document(), input=str(path), output=str(tmp_path / "o@2x.exr"))
    assert report.exit_code == 0
    assert (tmp_path / "o@2x.exr").exists()


def test_negative_frames_of_blender_are_done(tmp_path, out):
    for name in ("b-0001.exr", "b0000.exr", "b0001.exr"):
        plate(tmp_path / "in" / name)
    report = engine.run(document(), input=str(tmp_path / "in/b####.exr"), output=out)
    assert [each.frame for each in report.frames] == [-1, 0, 1]
    assert report.exit_code == 0
