"""A job template: its parameters and the words of its task; what cannot be said in one; and the spec's own checker."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError
from flowabs_nodes.submit.openjd_template import job_template

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
def here(tmp_path, monkeypatch):
    """A folder with a graph, as the current one."""
    folder = tmp_path / "job"
    folder.mkdir()
    (folder / "brighter.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    monkeypatch.chdir(folder)
    return folder


def parameters(template):
    return {each["name"]: each for each in template["parameterDefinitions"]}


def words(template):
    return template["steps"][0]["script"]["actions"]["onRun"]["args"]


def test_a_run_becomes_parameters_and_words(here):
    options = RunOptions(
        input="in.####.exr", output=["a.####.exr", "a.####.png"], frames="1001-1009x2,1020", set={"stops": 2}, jobs=2
    )
    template = job_template("brighter.json", options, chunk=3)
    defaults = {name: each["default"] for name, each in parameters(template).items()}
    assert defaults == {
        "Input": "in.####.exr",
        "Output": "a.####.exr",
        "Output2": "a.####.png",
        "Graph": "brighter.json",
        "Folder": ".",
        "Frames": "1001-1009:2,1020",
        "ChunkSize": 3,
    }
    assert words(template) == [
        "openjd-task",
        "--folder={{Param.Folder}}",
        "--input={{Param.Input}}",
        "--output={{Param.Output}}",
        "--output={{Param.Output2}}",
        "--frames={{Task.Param.Frame}}",
        "--set=stops=2",
        "--jobs=2",
        "{{Param.Graph}}",
    ]
    flows = [parameters(template)[name]["dataFlow"] for name in ("Graph", "Input", "Output", "Output2")]
    assert flows == ["IN", "IN", "OUT", "OUT"]
    assert list(here.iterdir()) == [here / "brighter.json"], "nothing else is made"


def test_without_frames_those_on_disk(here):
    for number in (3, 4, 9):
        (here / f"in.{number:04d}.exr").touch()
    template = job_template("lines", RunOptions(input="in.####.exr", output="a.####.exr"))
    assert parameters(template)["Frames"]["default"] == "3-4,9"
    assert words(template)[-1] == "lines"
    assert "Graph" not in parameters(template)


def test_a_file_below_the_folder_is_a_path_and_any_other_is_absolute(here):
    options = RunOptions(input=here / "plates" / "in.####.exr", output="../a.####.exr", frames="1-2")
    found = parameters(job_template("lines", options))
    assert (found["Input"]["type"], found["Input"]["default"]) == ("PATH", "plates/in.####.exr")
    assert found["Output"] == {"name": "Output", "type": "STRING", "default": str(here.parent / "a.####.exr")}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"output": "{{x}}.####.exr", "frames": "1-2"}, "reads {{ as an expression"),
        ({"frames": ",".join(str(n * n) for n in range(300))}, "of at most 1024 in a parameter"),
        ({"frames": "1-"}, "is not a frame range"),
        ({"scheduler": "local"}, "--scheduler is for a run"),
    ],
)
def test_what_cannot_be_said_in_a_template(here, options, said):
    with pytest.raises(CommandError) as caught:
        job_template("lines", RunOptions(**({"input": "in.####.exr", "output": "a.####.exr"} | options)))
    assert said in str(caught.value)


def test_the_specification_accepts_the_template(here):
    pytest.importorskip("openjd.cli", reason="needs the extra openjd")
    options = RunOptions(
        input="in.####.exr", output=["/far/a.####.exr", "a.####.png"], frames="-5-9x2", set={"stops": 2}
    )
    Path("job.json").write_text(json.dumps(job_template("brighter.json", options)), encoding="utf-8")
    command = [sys.executable, "-m", "openjd", "check", "job.json"]
    done = subprocess.run(command, capture_output=True, text=True, env=os.environ)
    assert done.returncode == 0, done.stdout + done.stderr
