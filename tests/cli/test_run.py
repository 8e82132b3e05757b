"""``flowabs run`` on small files: what is on disk, what is said, the exit code; and what it hands to the engine."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import cli
from flowabs_nodes.engine import render_sequence
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.file_choices import EXISTING, MISSING
from flowabs_nodes.simd import compile_hooks

ROOT = Path(__file__).resolve().parents[2]

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


def write(path, value=0.25, size=(8, 6)):
    buf = oiio.ImageBuf(oiio.ImageSpec(*size, 3, "half"))
    buf.set_pixels(buf.roi, np.full((size[1], size[0], 3), value, np.float32))
    assert buf.write(str(path))


def pixels(path):
    return oiio.ImageBuf(str(path)).get_pixels(oiio.FLOAT)


@pytest.fixture
def shot(tmp_path, monkeypatch):
    """A folder with a graph and frames 1001 to 1003, as the current one."""
    (tmp_path / "brighter.json").write_text(json.dumps(GRAPH), encoding="utf-8")
    for frame in (1001, 1002, 1003):
        write(tmp_path / f"in.{frame}.exr", frame / 1000 - 1)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def run(shot, capsys):
    """Run the graph: exit code, stdout, stderr."""

    def run(*arguments, graph="brighter.json"):
        code = cli.main(["run", str(graph), *map(str, arguments)])
        captured = capsys.readouterr()
        assert "Traceback" not in captured.err
        return code, captured.out, captured.err

    return run


def names(folder):
    return sorted(path.name for path in Path(folder).iterdir())


def test_a_sequence(run):
    code, out, err = run("-i", "in.####.exr", "-o", "made/out.####.exr")
    assert (code, err) == (0, "")
    assert out.splitlines()[-1].startswith("3 done in ")
    assert names("made") == ["out.1001.exr", "out.1002.exr", "out.1003.exr"]
    np.testing.assert_allclose(pixels("made/out.1002.exr"), 2 * pixels("in.1002.exr"), atol=1e-4)


def test_again_nothing_is_done_and_with_another_knob_everything(run):
    both = ("-i", "in.####.exr", "-o", "out.####.exr")
    assert run(*both)[1].splitlines()[-1].startswith("3 done")
    assert run(*both)[1].splitlines()[-1].startswith("3 skipped")
    assert run(*both, "--set", "stops=2")[1].splitlines()[-1].startswith("3 done")
    np.testing.assert_allclose(pixels("out.1003.exr"), 4 * pixels("in.1003.exr"), atol=1e-4)
    Path("out.1002.exr").write_bytes(Path("out.1002.exr").read_bytes()[:-10])
    assert run(*both, "--set", "stops=2")[1].splitlines()[-1].startswith("1 done, 2 skipped")


def test_two_formats_and_a_profile(run):
    code, out, _ = run("-i", "in.1001.exr", "-o", "a.exr", "-o", "a.png", "--profile")
    assert code == 0
    assert Path("a.exr").exists()
    assert oiio.ImageBuf("a.png").file_format_name == "png"
    assert [line.split()[0] for line in out.splitlines() if "exposure" in line] == ["brighter"]


def test_a_frame_that_is_missing_stops_no_other(run):
    code, out, err = run("-i", "in.####.exr", "-o", "out.####.exr", "--frames", "1001-1005x2,1002", "--json")
    events = [json.loads(line) for line in out.splitlines()]
    assert code == 1
    assert {event["frame"]: event["status"] for event in events if event["event"] == "frame"} == {
        1001: "done",
        1002: "done",
        1003: "done",
        1005: "failed",
    }
    assert events[-1]["exit_code"] == 1
    assert "in.1005.exr" in err
    assert run("-i", "in.####.exr", "-o", "out.####.exr", "--frames", "1001-1005", "--missing", "skip")[0] == 0
    assert not Path("out.1005.exr").exists()


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["-i", "in.####.exr"],
        ["-i", "in.####.exr", "-o", "out.exr"],
        ["-i", "in.####.exr", "-o", "in.####.exr"],
        ["-i", "in.1001.exr", "-o", "./in.1001.exr"],
        ["-i", "in.1001.exr", "-o", "out.jpg"],
        ["-i", "in.1001.exr", "-o", "out.exr", "-o", "out.exr"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--set", "stop=1"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--set", "stops=9"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--set", "plate.alpha=none"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--scale", "0"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--scale", "nan"],
        ["-i", "in.1001.exr", "-o", "out.exr", "--frames", "some"],
        ["-i", "in.1001.exr", "-o", "../out.exr", "--root", "."],
        ["-i", "gone.####.exr", "-o", "out.####.exr"],
    ],
    ids=" ".join,
)
def test_a_wrong_command_exits_2_and_writes_nothing(run, shot, arguments):
    before = names(shot)
    code, _, err = run(*arguments)
    assert code == 2
    assert err.startswith("flowabs: ")
    assert names(shot) == before
    assert not (shot.parent / "out.exr").exists()


def test_a_broken_graph_exits_2_with_every_problem(run, shot):
    (shot / "broken.json").write_text(json.dumps(GRAPH | {"nane": 1, "reference_height": 0}), encoding="utf-8")
    code, out, err = run("-i", "in.1001.exr", "-o", "out.exr", graph="broken.json")
    assert (code, out) == (2, "")
    assert "2 problems" in err
    assert "did you mean 'name'?" in err


@pytest.mark.parametrize("content", [b"", b"some text", "cut", None], ids=["empty", "text", "cut", "gone"])
def test_a_damaged_plate_exits_1_and_leaves_nothing(run, shot, content):
    if content == "cut":
        content = (shot / "in.1001.exr").read_bytes()[:-10]
    if content is not None:
        (shot / "bad.exr").write_bytes(content)
    before = names(shot)
    code, _, err = run("-i", "bad.exr", "-o", "out.exr")
    assert code == 1
    assert "bad.exr" in err
    assert names(shot) == before


def test_a_file_that_is_not_ours_is_left_alone(run, shot):
    write(shot / "out.exr")
    before = (shot / "out.exr").read_bytes()
    code, _, err = run("-i", "in.1001.exr", "-o", "out.exr")
    assert code == 1
    assert "overwrite" in err
    assert (shot / "out.exr").read_bytes() == before
    assert run("-i", "in.1001.exr", "-o", "out.exr", "--existing", "overwrite")[0] == 0
    assert (shot / "out.exr").read_bytes() != before
    assert run("-i", "in.1001.exr", "-o", "out.exr", "--existing", "error")[0] == 1


@pytest.mark.skipif(sys.platform == "win32", reason="no such signals")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_run_that_is_stopped_leaves_whole_frames_only(shot, number, code):
    write(shot / "large.0001.exr", size=(640, 480))
    for frame in range(2, 301):
        (shot / f"large.{frame:04}.exr").hardlink_to(shot / "large.0001.exr")
    files = [shot / "brighter.json", "-i", shot / "large.####.exr", "-o", shot / "made/out.####.exr"]
    command = [sys.executable, "-m", "flowabs_nodes", "run", *map(str, files)]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert any("done" in line for line in process.stdout)
        process.send_signal(number)
        _, err = process.communicate(timeout=180)
    assert process.returncode == code
    assert "Traceback" not in err
    assert 1 <= len(names("made")) < 300
    assert all(name.startswith("out.") and name.endswith(".exr") for name in names("made"))
    assert all(pixels(f"made/{name}") is not None for name in names("made"))


# ---------------------------------------------------------------------- what is handed to the engine, here a stand-in


def test_run_hands_everything_over(flowabs, fake_run, tmp_path):
    arguments = ["-i", "in.####.exr", "-o", "out.####.exr", "-o", "out.####.png", "--frames", "1001-1002"]
    arguments += [
        "--set",
        "line_width=1.5",
        "--set",
        "lines.kernel=full",
        "--set",
        "comp.ink=[1, 0, 0]",
        "--set",
        "a=b=c",
    ]
    arguments += ["--existing", "overwrite", "--missing", "hold", "--scale", "0.5", "--profile"]
    arguments += ["--root", tmp_path, "--max-pixels", "100", "--ocio", "studio.ocio"]
    assert flowabs("run", "abstraction", *arguments)[0] == 1
    options = RunOptions(
        input="in.####.exr",
        output=("out.####.exr", "out.####.png"),
        frames="1001-1002",
        set={"line_width": 1.5, "lines.kernel": "full", "comp.ink": [1, 0, 0], "a": "b=c"},
        scale=0.5,
        existing="overwrite",
        missing="hold",
        max_pixels=100,
        ocio="studio.ocio",
        root=tmp_path,
    )
    assert fake_run == [("abstraction", options, True)]


def test_run_without_options(flowabs, fake_run):
    flowabs("run", "lines")
    assert fake_run == [("lines", RunOptions(output=(), set={}), False)]


def test_the_words_of_the_options_are_the_engines():
    words = {option.name: getattr(option.type, "choices", None) for option in cli.run.params}
    assert tuple(words["existing"]) == EXISTING
    assert tuple(words["missing"]) == MISSING


def test_a_run_refuses_an_unknown_kernel_path_at_once(flowabs, monkeypatch):
    monkeypatch.setenv("FLOWABS_SIMD", "sse2")
    code, out, err = flowabs("run", "lines", "-i", "plate.exr", "-o", "out.exr")
    assert (code, out) == (2, "")
    assert "found 'sse2'" in err


def test_that_kernels_are_compiled_is_said_once_and_not_if_quiet(flowabs, fake_run, monkeypatch):
    told = render_sequence.render_sequence

    def compiling(*arguments, **options):
        compile_hooks.tell()
        compile_hooks.tell()
        return told(*arguments, **options)

    monkeypatch.setattr(render_sequence, "render_sequence", compiling)
    monkeypatch.setattr("flowabs_nodes.cli.precompile._begin", lambda *_: Ended())
    monkeypatch.setattr("flowabs_nodes.cli.precompile._load_ahead", lambda *_: None)
    assert flowabs("run", "lines")[1].count("kernels are being compiled") == 1
    assert "kernels" not in flowabs("run", "lines", "-q")[1]


class Ended:
    """A process that has ended."""

    def kill(self):
        """Do nothing."""

    def wait(self):
        """Do nothing."""
