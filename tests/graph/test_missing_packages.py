"""A node that needs a package which is not installed: said by check, refused by a run before its first frame."""

import sys
from dataclasses import replace

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import cli
from flowabs_nodes import graph as graphs
from flowabs_nodes.graph.problems import GraphError
from flowabs_nodes.nodes import catalogue

INSTALL = "pip install 'flowabs-nodes[compare]'"


@pytest.fixture
def no_opencv(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)


@pytest.mark.parametrize(("name", "nodes"), [("fig14", ["borders", "canny", "segments"]), ("fig21", ["mean_shift"])])
def test_check_names_each_node_and_what_to_install(no_opencv, capsys, name, nodes):
    problems = [each for each in graphs.check(name) if each.code == "missing-package"]
    assert sorted(each.pointer for each in problems) == [f"/nodes/{node}" for node in nodes]
    assert {each.hint for each in problems} == {INSTALL}
    assert cli.main(["check", name]) == 2
    assert INSTALL in capsys.readouterr().out


def test_what_is_installed_is_no_problem(no_opencv):
    assert graphs.check("lines") == []


def test_a_run_is_refused_before_its_first_frame(no_opencv, tmp_path, capsys):
    events = []
    with pytest.raises(GraphError) as caught:
        fa.run("fig21", input="no.####.exr", output=str(tmp_path / "o.####.exr"), frames="1-3", on_event=events.append)
    assert [problem.code for problem in caught.value.problems] == ["missing-package"]
    assert [event for event in events if event["event"] == "frame"] == []
    assert list(tmp_path.iterdir()) == []
    assert cli.main(["run", "fig14", "-i", "no.exr", "-o", str(tmp_path / "o.exr")]) == 2
    assert INSTALL in capsys.readouterr().err


def test_in_memory_only_the_nodes_that_run_count(no_opencv):
    graph = fa.load_graph("fig14")
    plate = fa.Image.from_array(np.full((12, 16, 3), 0.5, np.float32))
    assert graph.run(given={"plate": plate}, outputs="flow")["flow"].type == "flow"
    with pytest.raises(GraphError, match=r"canny@1 needs\n.*flowabs-nodes\[compare\]"):
        graph.run(given={"plate": plate}, outputs="canny")


def test_a_node_of_another_package_says_what_it_needs():
    packages = {"no_such_module_7": "their-nodes[glow]", "json": "python"}
    node = replace(catalogue()["blur"], type="glow", packages=packages)
    document = {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1", "params": {"file": "a.exr"}},
            "glow": {"type": "glow@1", "inputs": {"image": "plate"}},
            "out": {"type": "write@1", "inputs": {"image": "glow"}, "params": {"file": "b.exr"}},
        },
    }
    (problem,) = graphs.check(document, {**catalogue(), "glow": node})
    assert (problem.pointer, problem.found) == ("/nodes/glow", "no module no_such_module_7")
    assert problem.hint == "pip install 'their-nodes[glow]'"
