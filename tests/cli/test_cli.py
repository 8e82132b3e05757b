"""The process: what every command has in common, exit codes, signals, start-up and end."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import flowabs_nodes
from flowabs_nodes.errors import CommandError, FlowabsError, ReadError, WriteError
from flowabs_nodes.graph.problems import GraphError, Problem
from flowabs_nodes.simd import target
from tests.cli.conftest import RENDER_SEQUENCE

ROOT = Path(__file__).resolve().parents[2]


def test_help_of_every_command(flowabs):
    for command in ([], ["run"], ["check"], ["nodes"], ["schema"], ["graphs"]):
        code, out, err = flowabs(*command, "--help")
        assert (code, err) == (0, "")
        assert out.startswith("Usage: flowabs")


def test_without_a_command_it_helps(flowabs):
    code, out, err = flowabs()
    assert code == 2
    assert "Commands:" in out + err


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
    def render_sequence(*_, **__):
        raise error

    monkeypatch.setattr(RENDER_SEQUENCE, render_sequence)
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


STOPPED = """
import os, signal, sys, time
from flowabs_nodes import cli, stopping
from flowabs_nodes.engine import render_sequence

def stopped(*_, **__):
    os.kill(os.getpid(), int(sys.argv[1]))
    while True:
        stopping.check()
        time.sleep(0.01)

render_sequence.render_sequence = stopped
sys.exit(cli.main(["run", "lines"]))
"""


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_stops_it_without_a_traceback(number, code):
    command = [sys.executable, "-c", STOPPED, str(int(number))]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == code
    assert "Traceback" not in result.stderr


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
    code = "import atexit; from flowabs_nodes.__main__ import script; atexit.register(print, 'the end'); script()"
    result = subprocess.run([sys.executable, "-c", code, "--version"], cwd=ROOT, capture_output=True, text=True)
    assert (result.returncode, len(result.stdout.splitlines())) == (0, 2)
    assert "the end" in result.stdout.splitlines()


def test_threads_of_others_come_to_their_end():
    code = "import threading, time; from flowabs_nodes.__main__ import script; "
    code += "threading.Thread(target=lambda: (time.sleep(0.5), print('the end'))).start(); script()"
    result = subprocess.run([sys.executable, "-c", code, "--version"], cwd=ROOT, capture_output=True, text=True)
    assert (result.returncode, len(result.stdout.splitlines())) == (0, 2)
    assert "the end" in result.stdout.splitlines()


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
    assert b"gr\\xff.json" in result.stderr
