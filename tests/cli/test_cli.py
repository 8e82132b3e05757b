"""The command line, with the engine played by a stand-in; tests/test_run.py runs the real one."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import jsonschema
import pytest

import flowabs_nodes
from flowabs_nodes import cli, engine
from flowabs_nodes.choices import EXISTING, MISSING
from flowabs_nodes.cli import progress
from flowabs_nodes.engine.profile import NodeTime
from flowabs_nodes.engine.report import (
    FrameReport,
    Note,
    Report,
    end_event,
    frame_event,
    note_event,
    start_event,
)
from flowabs_nodes.errors import CommandError, FlowabsError, ReadError, WriteError
from flowabs_nodes.graph.problems import GraphError, Problem
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.simd import target

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def flowabs(capsys):
    """Run a command: exit code, stdout, stderr."""

    def run(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


DONE = FrameReport(
    1001,
    "done",
    ("out.1001.exr", "out.1001.png"),
    1.25,
    notes=(Note("gradient reference max = 83.2", "flow"), Note("clipped", "out", warning=True)),
)
FAILED = FrameReport(1002, "failed", ("out.1002.exr",), 0.5, ReadError("is cut short", file="in.1002.exr", frame=1002))
PROFILE = (NodeTime("flow", "etf", 2, 3.0, 2.0), NodeTime("lines", "fdog", 2, 1.0, 0.5))


@pytest.fixture
def fake_run(monkeypatch):
    """The engine's run, which notes how it is called, tells of two frames and returns a report."""
    calls = []

    def run(graph, *, on_event, **options):
        calls.append({"graph": graph, **options})
        on_event(start_event("toon", 2))
        on_event(note_event(Note("soft: fbl@1 read as fbl@2")))
        for frame in (DONE, FAILED):
            for note in frame.notes:
                on_event(note_event(note, frame.frame))
            on_event(frame_event(frame))
        report = Report((DONE, FAILED), 1, 2.0, profile=PROFILE if options["profile"] else None)
        on_event(end_event(report))
        return report

    monkeypatch.setattr(engine, "run", run)
    return calls


# ---------------------------------------------------------------------- run


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
    assert fake_run == [
        {
            "graph": "abstraction",
            "input": "in.####.exr",
            "output": ["out.####.exr", "out.####.png"],
            "frames": "1001-1002",
            "set": {"line_width": 1.5, "lines.kernel": "full", "comp.ink": [1, 0, 0], "a": "b=c"},
            "scale": 0.5,
            "existing": "overwrite",
            "missing": "hold",
            "profile": True,
            "settings": Settings(max_pixels=100, ocio="studio.ocio", root=tmp_path),
        }
    ]


def test_run_without_options(flowabs, fake_run):
    flowabs("run", "lines")
    (call,) = fake_run
    assert call["input"] is call["output"] is call["frames"] is call["set"] is call["missing"] is None
    assert (call["scale"], call["existing"], call["profile"]) == (1.0, "resume", False)
    assert call["settings"] == Settings()


def test_a_log_has_a_line_a_frame(flowabs, fake_run):
    code, out, err = flowabs("run", "lines")
    assert code == 1
    assert out.splitlines() == [
        "soft: fbl@1 read as fbl@2",
        "frame 1001  flow: gradient reference max = 83.2",
        "frame 1001  done       1.25 s  out.1001.exr, out.1001.png",
        "1 done, 1 failed in 2.00 s",
    ]
    assert err.splitlines() == [
        "frame 1001  warning: out: clipped",
        "frame 1002  failed  in.1002.exr: frame 1002: is cut short",
    ]


def test_a_profile_shows_seconds_and_shares(flowabs, fake_run):
    table = flowabs("run", "lines", "--profile")[1].splitlines()[-3:]
    assert table[0].split() == ["node", "type", "seconds", "share", "a", "frame", "longest"]
    assert table[1].split() == ["flow", "etf", "3.000", "75.0%", "1.500", "2.000"]
    assert table[2].split() == ["lines", "fdog", "1.000", "25.0%", "0.500", "0.500"]
    assert len({len(line) for line in table}) == 1


def test_json_is_an_event_a_line(flowabs, fake_run):
    code, out, err = flowabs("run", "lines", "--json", "--profile")
    assert code == 1
    events = [json.loads(line) for line in out.splitlines()]
    kinds = ["start", "note", "note", "note", "frame", "frame", "end", "profile"]
    assert [event["event"] for event in events] == kinds
    done, failed = events[4:6]
    assert (done["frame"], done["status"], done["file"], done["seconds"], done["error"]) == (
        1001,
        "done",
        "out.1001.exr",
        1.25,
        None,
    )
    assert failed["error"]["code"] == "read-failed"
    assert events[-1]["nodes"][0]["node"] == "flow"
    assert "is cut short" in err


def test_a_terminal_has_a_bar(flowabs, fake_run, monkeypatch):
    monkeypatch.setattr(progress, "on_a_terminal", lambda: True)
    code, out, err = flowabs("run", "lines")
    assert code == 1
    assert "2/2" in err
    assert re.search(r"\d (frames/s|s/ frames)|\? *frames/s", err), "frames a second"
    assert re.search(r"<\d\d:\d\d|<\?", err), "time left"
    assert "is cut short" in err
    assert "gradient reference" in out
    assert "1 done, 1 failed" in out


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (CommandError("output is the input"), 2),
        (GraphError([Problem("cycle", "/nodes/a", "a -> a", "none")]), 2),
        (FlowabsError("something"), 2),
        (ReadError("no such file", file="in.exr"), 1),
        (WriteError("disk full", file="out.exr"), 1),
        (PermissionError(13, "Permission denied", "out"), 1),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_errors_are_said_and_leave_an_exit_code(flowabs, monkeypatch, error, code, as_json):
    def run(*_, **__):
        raise error

    monkeypatch.setattr(engine, "run", run)
    found, out, err = flowabs("run", "lines", *(["--json"] if as_json else []))
    assert found == code
    assert err.startswith(f"flowabs: {error}")
    assert "Traceback" not in err
    if as_json and isinstance(error, FlowabsError):
        assert json.loads(out)["error"]["code"] == error.code
    else:
        assert out == ""


@pytest.mark.parametrize(
    "arguments",
    [
        ["run"],
        ["run", "lines", "--nothing"],
        ["run", "lines", "--set", "line_width"],
        ["run", "lines", "--set", "=1"],
        ["run", "lines", "--existing", "skip"],
        ["run", "lines", "--missing", "checker"],
        ["run", "lines", "--scale", "half"],
        ["run", "lines", "--max-pixels", "0"],
        ["nothing"],
        ["check"],
        ["nodes", "a", "b"],
    ],
)
def test_a_wrong_command_exits_2(flowabs, fake_run, arguments):
    code, out, err = flowabs(*arguments)
    assert (code, out) == (2, "")
    assert "Usage:" in err
    assert not fake_run


def test_the_words_of_the_options_are_the_engines():
    words = {option.name: getattr(option.type, "choices", None) for option in cli.run.params}
    assert tuple(words["existing"]) == EXISTING
    assert tuple(words["missing"]) == MISSING


STOPPED = """
import os, signal, sys, time
from flowabs_nodes import cli, engine

def run(*_, **__):
    os.kill(os.getpid(), int(sys.argv[1]))
    time.sleep(30)

engine.run = run
sys.exit(cli.main(["run", "lines"]))
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_stops_it_without_a_traceback(number, code):
    command = [sys.executable, "-c", STOPPED, str(int(number))]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == code
    assert "Traceback" not in result.stderr


# ---------------------------------------------------------------------- check


GOOD = {"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}, "out": {"type": "write@1"}}}


def graph_file(tmp_path, **nodes):
    path = tmp_path / "graph.json"
    document = {"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}, **nodes}}
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


OUT = {"type": "write@1", "inputs": {"image": "plate"}}


def test_check_says_ok(flowabs, tmp_path):
    assert flowabs("check", graph_file(tmp_path, out=OUT)) == (0, "ok\n", "")
    assert flowabs("check", "abstraction") == (0, "ok\n", "")


def test_warnings_alone_exit_0(flowabs, tmp_path):
    code, out, _ = flowabs("check", graph_file(tmp_path, out=OUT, flow={"type": "etf@1", "inputs": {"image": "plate"}}))
    assert code == 0
    assert "unused-node (warning)  /nodes/flow" in out
    assert out.endswith("ok, 1 warning\n")


def test_check_shows_every_problem(flowabs, tmp_path):
    flow = {"type": "etf@1", "inputs": {"image": "plat"}, "params": {"radius": -1, "raduis": 5}}
    code, out, _ = flowabs("check", graph_file(tmp_path, flow=flow))
    assert code == 2
    assert out == (
        "out-of-range  /nodes/flow/params/radius\n"
        "  found     -1\n"
        "  expected  a number from 0 to 500 (px)\n\n"
        "unknown-param  /nodes/flow/params/raduis\n"
        '  found     "raduis"\n'
        "  expected  a parameter of etf@1\n"
        "  hint      did you mean 'radius'?\n\n"
        "unknown-node  /nodes/flow/inputs/image\n"
        '  found     "plat"\n'
        "  expected  a node of this graph\n"
        "  hint      did you mean 'plate'?\n\n"
        "3 errors\n"
    )


def test_check_in_json(flowabs, tmp_path):
    code, out, _ = flowabs("check", graph_file(tmp_path, flow={"type": "eft@1"}), "--json")
    assert code == 2
    result = json.loads(out)
    assert result["ok"] is False
    (problem,) = result["problems"]
    assert problem.keys() == {"code", "pointer", "found", "expected", "hint"}
    assert problem["code"] == "unknown-type"
    assert json.loads(flowabs("check", "lines", "--json")[1]) == {"ok": True, "problems": []}


@pytest.mark.parametrize("name", ["nothing", "./nothing.json", "/"])
def test_check_of_what_is_not_there(flowabs, name):
    code, out, err = flowabs("check", name)
    assert (code, out) == (2, "")
    assert err.startswith("flowabs: ")


# ---------------------------------------------------------------------- nodes, schema, graphs


def test_nodes(flowabs):
    code, out, _ = flowabs("nodes")
    assert code == 0
    assert any(line.startswith("etf@1 ") for line in out.splitlines())
    for name in ("etf", "etf@1"):
        code, out, _ = flowabs("nodes", name)
        assert code == 0
        assert "radius: a number from 0 to 500 (px)" in out


@pytest.mark.parametrize(("name", "hint"), [("eft", "'etf'"), ("etf@7", "'etf@1'")])
def test_a_node_that_is_not_there(flowabs, name, hint):
    code, out, err = flowabs("nodes", name)
    assert (code, out) == (2, "")
    assert hint in err


def test_schema(flowabs):
    code, out, _ = flowabs("schema")
    assert code == 0
    jsonschema.Draft202012Validator.check_schema(json.loads(out))


def test_graphs(flowabs):
    code, out, _ = flowabs("graphs")
    assert code == 0
    assert "abstraction" in out.splitlines()
    assert "line_width 0.5 to 2.5 px (1.0) Width of the ink." in " ".join(out.split())


def test_nodes_that_could_not_be_loaded_are_named(flowabs, monkeypatch):
    monkeypatch.setattr("flowabs_nodes.nodes.load_problems", lambda: {"their-nodes: glow": "ImportError: no"})
    for command in (["nodes"], ["check", "lines"], ["schema"]):
        code, _, err = flowabs(*command)
        assert code == 0
        assert "their-nodes: glow: ImportError: no" in err


# ---------------------------------------------------------------------- the process


def test_version(flowabs):
    assert flowabs("--version") == (0, f"flowabs {flowabs_nodes.__version__} (kernels: {target.PATH})\n", "")


@pytest.mark.parametrize(
    ("asked", "code", "out", "err"),
    [
        ("portable", 0, f"flowabs {flowabs_nodes.__version__} (kernels: portable)\n", ""),
        ("sse2", 2, "", "flowabs: FLOWABS_SIMD: expected auto, avx512, portable or nothing, found 'sse2'"),
    ],
)
def test_version_says_which_kernels_were_asked_for(asked, code, out, err):
    command = [sys.executable, "-m", "flowabs_nodes", "--version"]
    use = {**os.environ, "FLOWABS_SIMD": asked}
    result = subprocess.run(command, cwd=ROOT, env=use, capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (code, out)
    assert err in result.stderr
    assert "Traceback" not in result.stderr


def test_a_run_refuses_an_unknown_kernel_path_at_once(flowabs, monkeypatch):
    monkeypatch.setenv("FLOWABS_SIMD", "sse2")
    code, out, err = flowabs("run", "lines", "-i", "plate.exr", "-o", "out.exr")
    assert (code, out) == (2, "")
    assert "found 'sse2'" in err


def test_help_of_every_command(flowabs):
    for command in ([], ["run"], ["check"], ["nodes"], ["schema"], ["graphs"]):
        code, out, err = flowabs(*command, "--help")
        assert (code, err) == (0, "")
        assert out.startswith("Usage: flowabs")


def test_without_a_command_it_helps(flowabs):
    code, out, err = flowabs()
    assert code == 2
    assert "Commands:" in out + err


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["--version"],
        ["run", "--help"],
        ["check", "abstraction"],
        ["nodes"],
        ["nodes", "fbl"],
        ["schema"],
        ["graphs"],
    ],
)
def test_start_up_needs_no_kernels(arguments):
    code = (
        "import sys; from flowabs_nodes.cli import main; code = main(sys.argv[1:]); "
        "print(code, sorted({'numba', 'colour', 'scipy', 'cv2'} & set(sys.modules)), file=sys.stderr)"
    )
    result = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=True)
    assert result.stderr.splitlines()[-1] == "0 []"


def test_as_a_module():
    result = subprocess.run([sys.executable, "-m", "flowabs_nodes", "check", "lines"], capture_output=True, text=True)
    assert (result.returncode, result.stdout, result.stderr) == (0, "ok\n", "")


def test_what_asks_to_be_called_at_the_end_is_called():
    code = "import atexit; from flowabs_nodes.cli import script; atexit.register(print, 'the end'); script()"
    result = subprocess.run([sys.executable, "-c", code, "--version"], cwd=ROOT, capture_output=True, text=True)
    assert (result.returncode, result.stdout.splitlines()[1:]) == (0, ["the end"])


def test_threads_of_others_come_to_their_end():
    code = "import threading, time; from flowabs_nodes.cli import script; "
    code += "threading.Thread(target=lambda: (time.sleep(0.5), print('the end'))).start(); script()"
    result = subprocess.run([sys.executable, "-c", code, "--version"], cwd=ROOT, capture_output=True, text=True)
    assert (result.returncode, result.stdout.splitlines()[1:]) == (0, ["the end"])


def test_a_reader_that_goes_away_is_no_error():
    command = [sys.executable, "-m", "flowabs_nodes", "schema"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        error = process.stderr.read()
    assert b"Traceback" not in error


@pytest.mark.skipif(os.name == "nt", reason="file names are text there")
def test_names_that_are_no_text_can_be_shown(tmp_path):
    name = os.fsencode(tmp_path) + b"/gr\xff.json"
    result = subprocess.run([sys.executable, "-m", "flowabs_nodes", "check", name], capture_output=True)
    assert result.returncode == 2
    assert b"Traceback" not in result.stderr
    assert b"gr\\udcff.json" in result.stderr
