"""Which schedulers and workers of Dask a run takes, and what it says of those that it does not."""

import os
import pickle
import socket
import sys
import threading
import time
from contextlib import suppress

import pytest

import flowabs_nodes
from flowabs_nodes.engine import dask_cluster, dask_connection, dask_worker
from flowabs_nodes.engine.dask_worker import Place
from flowabs_nodes.engine.job_builder import build_job
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.errors import ArgumentError, CommandError
from tests.engine import windows
from tests.engine.sequences import document, graph_around, plates, run, statuses

ALL_DONE = [(frame, "done") for frame in (1, 2, 3)]


def listening():
    """Return the addresses that this process and those below it listen at."""
    import psutil

    me = psutil.Process()
    connections = (each for process in (me, *me.children()) for each in process.net_connections())
    return {each.laddr.ip for each in connections if each.status == psutil.CONN_LISTEN}


#: The files that a worker was to look at, and whether they were there.
seen: dict[str, bool] = {}


def look_and_refuse(job, folder, marks, dask_worker=None):
    seen.update({path: os.path.exists(path) for path in marks})
    return Place("host", 1, 10**9, "does not see the files of this run in /somewhere")


@pytest.mark.parametrize(
    "scheduler", ["", "here", "http://host:1", "tcp://host", "tcp://:8786", "tcp://a:b", "tcp://host:1/x", "local:2", 3]
)
def test_what_is_no_scheduler_is_refused_by_its_name(scheduler):
    with pytest.raises(ArgumentError, match=r"scheduler: expected local or tcp://HOST:PORT, found") as caught:
        RunOptions(scheduler=scheduler)
    assert caught.value.parameter == "scheduler"


@pytest.mark.parametrize("scheduler", ["local", "tcp://host:8786", "tcp://10.0.0.1:1", "tcp://[::1]:8786"])
def test_what_is_one_is_taken(scheduler):
    assert RunOptions(scheduler=scheduler).scheduler == scheduler


def test_without_dask_the_extra_is_named(shot, out, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(CommandError, match="not installed") as caught:
        run(shot, out, scheduler="local")
    assert (caught.value.code, caught.value.hint) == ("no-dask", 'pip install "flowabs-nodes[dask]"')
    assert not os.path.exists(os.path.dirname(out))


def test_nodes_that_a_script_made_up_stay_here_and_that_is_said(shot, out, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    events = []
    graph = graph_around(lambda context, image: image)
    assert statuses(run(shot, out, graph, scheduler="local", on_event=events.append)) == ALL_DONE
    assert [event for event in events if "rendered in this process" in event.get("text", "")]


class TestWithDask:
    @pytest.fixture(autouse=True)
    def _dask(self):
        pytest.importorskip("distributed", reason="the extra dask is not installed")

    def test_a_scheduler_that_does_not_answer_is_named_and_nothing_is_made(self, shot, out, monkeypatch):
        monkeypatch.setattr(dask_connection, "CONNECT", 1.0)
        begun = time.monotonic()
        with pytest.raises(CommandError, match=r"tcp://127.0.0.1:9: no scheduler of Dask answers within 1 s") as caught:
            run(shot, out, scheduler="tcp://127.0.0.1:9")
        assert caught.value.code == "no-scheduler"
        assert time.monotonic() - begun < 8
        assert not os.path.exists(os.path.dirname(out))

    @pytest.mark.parametrize("answer", [b"HTTP/1.1 400 Bad Request\r\n\r\n", b""])
    def test_whoever_else_answers_is_no_scheduler(self, shot, out, monkeypatch, answer):
        monkeypatch.setattr(dask_connection, "CONNECT", 1.0)
        with socket.create_server(("127.0.0.1", 0)) as server:
            taken = []

            def take():
                with suppress(OSError):
                    while True:
                        taken.append(server.accept()[0])
                        taken[-1].sendall(answer)

            threading.Thread(target=take, daemon=True).start()
            with pytest.raises(CommandError, match="no scheduler of Dask") as caught:
                run(shot, out, scheduler=f"tcp://127.0.0.1:{server.getsockname()[1]}")
        for each in taken:
            each.close()
        assert taken
        assert caught.value.code == "no-scheduler"

    def test_workers_of_this_machine_are_reached_by_nobody_else(self, shot, out):
        before, during = listening(), set()
        events = []

        def listen(event):
            events.append(event)
            during.update(listening())

        assert statuses(run(shot, out, scheduler="local", jobs=2, on_event=listen)) == ALL_DONE
        assert during - before <= {"127.0.0.1"}
        assert listening() == before
        assert events[0]["event"] == "start"
        assert [event["text"] for event in events if "Dask" in event.get("text", "")] == [
            "Dask on this machine: 2 workers, 2 frames at once"
        ]

    def test_a_scheduler_without_workers_is_told(self, shot, out, farm, monkeypatch):
        monkeypatch.setattr(dask_connection, "CONNECT", 1.0)
        with pytest.raises(CommandError, match="the scheduler has no workers") as caught:
            run(shot, out, scheduler=farm.address)
        assert caught.value.code == "no-worker"
        assert farm.address in caught.value.hint

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("code", "why"),
        [
            ("raise ImportError", f"has no flowabs-nodes: install {flowabs_nodes.__version__} in its environment"),
            ("__version__ = '0.0.1'", f"has flowabs-nodes 0.0.1, and this run is one of {flowabs_nodes.__version__}"),
        ],
    )
    def test_a_worker_with_another_package_is_passed_over(self, shot, out, tmp_path, farm, code, why):
        (tmp_path / "first/flowabs_nodes").mkdir(parents=True)
        (tmp_path / "first/flowabs_nodes/__init__.py").write_text(code)
        farm.worker(first=tmp_path / "first")
        with pytest.raises(CommandError, match="no worker can render frames: tcp://") as caught:
            run(shot, out, scheduler=farm.address)
        assert caught.value.code == "no-worker"
        assert why in str(caught.value)
        assert not os.path.exists(os.path.dirname(out))
        farm.worker()
        events = []
        assert statuses(run(shot, out, scheduler=farm.address, on_event=events.append)) == ALL_DONE
        told = [event["text"] for event in events if event["event"] == "note" and event["level"] == "warning"]
        assert [text for text in told if "is passed over" in text and why in text]

    @pytest.fixture
    def farm(self, tmp_path):
        from tests.engine.dask_farm import Farm

        (tmp_path / "farm").mkdir()
        farm = Farm(tmp_path / "farm")
        yield farm
        farm.end()

    def test_the_files_that_a_worker_has_to_see_are_there_for_a_moment_only(self, shot, out, monkeypatch):
        seen.clear()
        monkeypatch.setattr(dask_cluster, "look_around", look_and_refuse)
        with pytest.raises(CommandError, match="does not see the files of this run in /somewhere"):
            run(shot, out, scheduler="local", jobs=1)
        assert all(seen.values())
        marks = [path for path in seen if path.endswith(".probe")]
        assert [os.path.dirname(path) for path in marks] == [os.path.dirname(os.path.dirname(out))]
        assert shot.replace("####", "0001") in seen
        assert not any(map(os.path.exists, marks))


@pytest.fixture
def job(shot, out):
    return pickle.dumps(build_job(load_graph(document()), RunOptions(input=shot, output=out))[0])


def test_a_worker_says_why_it_can_do_nothing(job, tmp_path):
    here = str(tmp_path)
    assert dask_worker._why_not(job, here, {"in/plate.0001.exr": (tmp_path / "in/plate.0001.exr").stat().st_size}) == ""
    assert "does not see the folder of this run" in dask_worker._why_not(job, f"{here}/nowhere", {})
    for marks in ({"in/plate.0009.exr": 1}, {"in/plate.0001.exr": 1}):
        assert f"does not see the files of this run in {here}/in" in dask_worker._why_not(job, here, marks)


def test_a_worker_without_a_node_of_the_graph_says_so(tmp_path, monkeypatch):
    graph = windows.load(windows.chain("mean"), windows.MEAN)
    asked = RunOptions(input=plates(tmp_path, 1), output=tmp_path / "o.####.exr")
    job = pickle.dumps(build_job(graph, asked)[0])
    assert dask_worker._why_not(job, str(tmp_path), {}) == ""
    monkeypatch.delattr(windows, "run_mean")
    assert "cannot load the graph: " in dask_worker._why_not(job, str(tmp_path), {})
