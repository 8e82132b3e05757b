"""``flowabs nodes``, ``flowabs schema`` and ``flowabs graphs``."""

import json

import jsonschema
import pytest

from flowabs_nodes.graph.shipped import paper, shipped
from flowabs_nodes.nodes import catalogue


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


def test_nodes_for_programs(flowabs):
    _, out, _ = flowabs("nodes", "--json")
    listed = json.loads(out)
    assert [node["type"] for node in listed] == list(catalogue())
    code, out, _ = flowabs("nodes", "fdog@1", "--json")
    fdog = json.loads(out)
    assert (code, fdog) == (0, next(node for node in listed if node["type"] == "fdog"))
    assert [port["name"] for port in fdog["inputs"]] == [port.name for port in catalogue()["fdog"].inputs]
    (tau,) = [param for param in fdog["params"] if param["name"] == "tau"]
    assert (tau["kind"], tau["default"], tau["min"], tau["max"]) == ("float", 0.5, 0, 1)
    assert flowabs("nodes", "fdgo", "--json")[0] == 2


def test_a_graphs_file_goes_to_stdout_as_it_is(flowabs, tmp_path):
    for name, path in (shipped() | paper()).items():
        code, out, err = flowabs("graphs", name)
        assert (code, out, err) == (0, path.read_text(encoding="utf-8"), "")
    (tmp_path / "my.json").write_text(flowabs("graphs", "lines")[1])
    assert flowabs("check", tmp_path / "my.json")[:2] == (0, "ok\n")


def test_on_a_terminal_it_also_says_what_to_do_with_it(flowabs, monkeypatch):
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    _, out, err = flowabs("graphs", "flat")
    assert out.startswith("{")
    assert "flowabs graphs flat > my.json" in err


@pytest.mark.parametrize(("name", "hint"), [("abstracton", "'abstraction'"), ("fig7", "'fig07'")])
def test_a_graph_that_is_not_there(flowabs, name, hint):
    for arguments in ([name], [name, "--json"]):
        code, out, err = flowabs("graphs", *arguments)
        assert (code, out) == (2, "")
        assert hint in err


def test_graphs_for_programs(flowabs):
    listed = json.loads(flowabs("graphs", "--json")[1])
    assert [graph["name"] for graph in listed] == list(shipped() | paper())
    assert [graph["name"] for graph in listed if graph["figure"]] == list(paper())
    one = json.loads(flowabs("graphs", "abstraction", "--json")[1])
    assert one in listed
    assert one["knobs"][0] == {
        "name": "line_width",
        "type": "float",
        "label": "Line width",
        "group": "Lines",
        "default": 1.0,
        "min": 0.5,
        "max": 2.5,
        "unit": "px",
        "choices": [],
        "help": "Width of the ink.",
    }
