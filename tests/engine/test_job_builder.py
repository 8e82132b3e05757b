"""Jobs: how small they are, and which commands are refused before anything is written."""

import pickle
from dataclasses import replace

import pytest

from flowabs_nodes import engine
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import CommandError, FlowabsError
from flowabs_nodes.io.settings import Settings
from tests.engine.sequences import document


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
