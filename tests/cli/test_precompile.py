"""Kernels compiled ahead by another process."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.cli import precompile
from flowabs_nodes.image import Image
from flowabs_nodes.simd import bands, compile_hooks

ROOT = Path(__file__).resolve().parents[2]
GRAPH = {
    "format": "flowabs.graph/1",
    "name": "small",
    "interface": {"size": {"type": "float", "default": 1.0, "help": "of the blur"}},
    "nodes": {
        "plate": {"type": "read@1"},
        "soft": {"type": "blur@1", "inputs": {"image": "plate"}, "params": {"sigma": {"from": "size"}}},
        "lines": {"type": "dog@1", "inputs": {"image": "soft"}},
        "out": {"type": "write@1", "inputs": {"image": "lines"}},
    },
}
COUNTED = """
import sys
from numba.core import event
from flowabs_nodes.cli import main
with event.install_recorder("numba:compile") as recorder:
    code = main(sys.argv[1:])
print(code, sorted({each.data["dispatcher"].py_func.__name__ for _, each in recorder.buffer}))
print(sorted({"colour", "scipy.linalg", "numba.np.arrayobj", "fileseq", "tqdm"} & set(sys.modules)))
"""


@pytest.fixture
def graph(tmp_path):
    file = tmp_path / "small.json"
    file.write_text(json.dumps(GRAPH))
    return str(file)


@pytest.fixture
def begun(monkeypatch):
    """Processes that were begun, of which none ends by itself."""
    processes = []

    def begin(graph, values):
        processes.append(subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"]))
        return processes[-1]

    monkeypatch.setattr(precompile, "_begin", begin)
    yield processes
    for process in processes:
        process.kill()
        process.wait()


@pytest.fixture
def no_thread(monkeypatch):
    monkeypatch.setattr(precompile, "_load_ahead", lambda *arguments: None)


def test_it_begins_when_a_kernel_is_missing_and_ends_with_the_run(begun, no_thread):
    with bands.limited(2), precompile.compiling_ahead("lines", {}):
        assert begun == []
        compile_hooks.tell()
        compile_hooks.tell()
        assert len(begun) == 1
        assert begun[0].poll() is None
    assert begun[0].poll() is not None


def test_it_ends_with_a_run_that_fails(begun, no_thread):
    def run():
        with bands.limited(2), precompile.compiling_ahead("lines", {}):
            compile_hooks.tell()
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run()
    assert begun[0].poll() is not None


def test_where_all_kernels_are_there_nothing_begins(begun, no_thread):
    with bands.limited(2), precompile.compiling_ahead("lines", {}):
        pass
    compile_hooks.tell()
    assert begun == []


def test_on_one_processor_nothing_begins(begun, no_thread):
    with bands.limited(1), precompile.compiling_ahead("lines", {}):
        compile_hooks.tell()
    assert begun == []


def test_without_another_process_the_run_goes_on(monkeypatch, no_thread):
    asked = []

    def begin(graph, values):
        asked.append(graph)
        raise BlockingIOError("no more processes")

    monkeypatch.setattr(precompile, "_begin", begin)
    with bands.limited(2), precompile.compiling_ahead("lines", {}):
        compile_hooks.tell()
        compile_hooks.tell()
    assert asked == ["lines"]


def test_what_it_leaves_on_disk_is_what_the_run_needs(graph, tmp_path):
    plate = tmp_path / "plate.exr"
    Image.from_array(np.random.default_rng(1).random((40, 60, 3), np.float32)).to_imagebuf().write(str(plate))
    use = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    run = ["run", graph, "-i", plate, "-o", tmp_path / "out.exr", "--set", "size=2"]

    command = [sys.executable, "-m", "flowabs_nodes.cli.precompile", graph, '{"size": 2}']
    with subprocess.Popen(command, cwd=ROOT, env=use, stdin=subprocess.PIPE) as ahead:
        assert ahead.wait(300) == 0
    done = subprocess.run(
        [sys.executable, "-c", COUNTED, *run], cwd=ROOT, env=use, capture_output=True, text=True, check=True
    )
    compiled, slow_to_import = done.stdout.splitlines()[-2:]
    assert compiled == "0 []"
    assert slow_to_import == "[]"


def test_a_graph_that_is_wrong_is_the_run_s_business(tmp_path):
    with precompile._begin(str(tmp_path / "none.json"), {}) as done:
        assert done.wait(60) != 0


def test_the_other_process_imports_nothing_from_the_current_folder(graph, tmp_path, monkeypatch):
    for name in ("json", "numpy", "flowabs_nodes"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'imported')!r}, 'w').close()")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    for here in ("", "."):  # both mean the current folder
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join([here, str(ROOT)]))
        with precompile._begin(graph, {}) as ahead:
            assert ahead.wait(300) == 0
        assert not (tmp_path / "imported").exists()
    assert list((tmp_path / "kernels").rglob("*.kernel"))


@pytest.mark.skipif(os.name == "nt", reason="SIGKILL")
def test_the_other_process_ends_when_this_one_is_killed(graph, tmp_path):
    code = f"""
import time
from flowabs_nodes.cli import precompile
print(precompile._begin({graph!r}, {{}}).pid, flush=True)
time.sleep(600)
"""
    use = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    with subprocess.Popen([sys.executable, "-c", code], env=use, stdout=subprocess.PIPE, text=True) as parent:
        other = int(parent.stdout.readline())
        os.kill(other, 0)
        time.sleep(0.5)  # in the middle of importing or compiling, which takes many seconds
        parent.send_signal(signal.SIGKILL)
    end = time.monotonic() + 5
    while time.monotonic() < end and _lives(other):
        time.sleep(0.05)
    assert not _lives(other)


def _lives(pid):
    try:
        os.kill(pid, 0)
        # Nobody may have waited for it: then it has ended, and its number is still taken.
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_the_thread_leaves_nodes_of_other_packages_alone_and_ends_with_the_run(graph, monkeypatch):
    from flowabs_nodes.engine.runnable import RunnableGraph

    ran = []
    monkeypatch.setattr(RunnableGraph, "run", lambda self, given, outputs, **_: ran.append(outputs) or {})
    precompile.run_small(graph, {}, own_only=True)
    assert ran == [["soft.image"], ["lines.lines"]]
    ran.clear()
    precompile.run_small(graph, {}, backwards=True)
    assert ran == [["lines.lines"], ["soft.image"]]
    ran.clear()
    precompile.run_small(graph, {}, own_only=True, over=lambda: bool(ran))
    assert ran == [["soft.image"]]
    ran.clear()
    monkeypatch.setattr("flowabs_nodes.nodes.lines.run_dog.__module__", "another_package")
    precompile.run_small(graph, {}, own_only=True)
    assert ran == [["soft.image"]]


def test_the_thread_keeps_quiet_about_a_graph_that_is_wrong(tmp_path, capfd):
    with bands.limited(2), precompile.compiling_ahead(str(tmp_path / "none.json"), {}):
        for thread in threading.enumerate():
            if thread.name == "flowabs-ahead":
                thread.join(60)
    assert capfd.readouterr() == ("", "")


def test_a_node_that_reads_other_frames_gets_some(tmp_path, monkeypatch):
    from flowabs_nodes.filters.motion import window

    given, plain = [], window.motion_window
    monkeypatch.setattr(
        window, "motion_window", lambda images, *more, **how: given.append(set(images)) or plain(images, *more, **how)
    )
    inputs = {"image": "plate", "motion": "motion"}
    nodes = {
        "plate": {"type": "read@1"},
        "motion": {"type": "read_motion@1"},
        "steady": {"type": "motion_window@1", "inputs": inputs},
        "out": {"type": "write@1", "inputs": {"image": "steady"}},
    }
    file = tmp_path / "steady.json"
    file.write_text(json.dumps({"format": "flowabs.graph/1", "name": "steady", "nodes": nodes}))
    precompile.run_small(str(file), {})
    assert given == [{-1, 0, 1}]
