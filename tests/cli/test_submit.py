"""``flowabs submit openjd`` and the task of its job: what is printed, what is on disk, the exit codes."""

import json
import os
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

GRAPH = {
    "format": "flowabs.graph/1",
    "name": "brighter",
    "interface": {"stops": {"type": "float", "default": 1, "min": -5, "max": 5}},
    "nodes": {
        "plate": {"type": "read@1"},
        "brighter": {"type": "exposure@1", "inputs": {"image": "plate"}, "params": {"stops": {"from": "stops"}}},
        "out": {"type": "write@1", "inputs": {"image": "brighter"}},
    },
}


@pytest.fixture
def shot(tmp_path, monkeypatch):
    """A folder with a graph and frames 1 to 3, as the current one."""
    (tmp_path / "brighter.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    for frame in (1, 2, 3):
        buf = oiio.ImageBuf(oiio.ImageSpec(8, 6, 3, "half"))
        buf.set_pixels(buf.roi, np.full((6, 8, 3), 0.25, np.float32))
        assert buf.write(str(tmp_path / f"in.{frame:04d}.exr"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def job_words(out, folder, frames):
    """Return the words of a task as a farm would call it, with the default of each parameter."""
    template = json.loads(out)
    words = template["steps"][0]["script"]["actions"]["onRun"]["args"]
    values = {"Task.Param.Frame": frames}
    for each in template["parameterDefinitions"]:
        value = each["default"]
        values[f"Param.{each['name']}"] = str(folder / value) if each["type"] == "PATH" else str(value)
    for name, value in values.items():
        words = [word.replace("{{" + name + "}}", value) for word in words]
    return words


def test_the_task_of_a_job_makes_its_frames_and_tells_the_farm(flowabs, shot, tmp_path_factory, monkeypatch):
    files = ("-i", "in.####.exr", "-o", "made/out.####.exr")
    code, out, err = flowabs("submit", "openjd", "brighter.json", *files, "--set", "stops=2", "--jobs", "1")
    assert (code, err) == (0, "")
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    code, said, err = flowabs(*job_words(out, shot, "1-3:2"))
    assert (code, err) == (0, "")
    assert said.splitlines() == [
        "openjd_status: brighter: 2 frames to make",
        "openjd_status: frame 1 done, 1 of 2",
        "openjd_progress: 50.0",
        "openjd_status: frame 3 done, 2 of 2",
        "openjd_progress: 100.0",
    ]
    assert sorted(path.name for path in (shot / "made").iterdir()) == ["out.0001.exr", "out.0003.exr"]
    made = oiio.ImageBuf(str(shot / "made" / "out.0003.exr")).get_pixels(oiio.FLOAT)
    np.testing.assert_allclose(made, 1.0, atol=1e-3)
    assert Path.cwd() == shot, "names that are not absolute begin in the job's folder"


def test_a_frame_that_fails_is_told_to_the_farm(flowabs, shot):
    files = ("-i", "in.####.exr", "-o", "out.####.exr")
    code, out, _ = flowabs("openjd-task", "brighter.json", *files, "--frames", "3,4", "--jobs", "1")
    assert code == 1
    failed = [line for line in out.splitlines() if line.startswith("openjd_fail: ")]
    assert len(failed) == 1
    assert failed[0].startswith("openjd_fail: frame 4: ")
    assert "in.0004.exr" in failed[0]
    assert out.splitlines()[-1] == "openjd_progress: 100.0"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("brighter.json", "--frames", "1-9x2"), "'1-9x2' is not a range of Open Job Description"),
        (("nothing.json", "--frames", "1"), "nothing.json"),
        (("brighter.json", "--frames", "1", "--scale", "7"), "scale"),
        (("brighter.json", "--frames", "1", "--folder", "not/there"), "the job's folder is not to be had here"),
    ],
)
def test_a_task_that_cannot_begin_says_why(flowabs, shot, words, said):
    code, out, err = flowabs("openjd-task", "-i", "in.####.exr", "-o", "out.####.exr", *words)
    assert code == 2
    assert out.startswith("openjd_fail: ")
    assert out.count("\n") == 1
    assert said in out
    assert err.startswith("flowabs: ")


def test_a_wrong_run_is_no_job(flowabs, shot):
    code, out, err = flowabs("submit", "openjd", "brighter.json", "-i", "in.####.exr")
    assert (code, out) == (2, "")
    assert "no file to write is set" in err
    assert sorted(os.listdir()) == ["brighter.json", "in.0001.exr", "in.0002.exr", "in.0003.exr"]


def test_the_task_is_not_in_the_help(flowabs):
    out = flowabs("--help")[1]
    assert "submit" in out
    assert "openjd-task" not in out
