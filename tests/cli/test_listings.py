"""``flowabs nodes``, ``flowabs schema`` and ``flowabs graphs``."""

import json

import jsonschema
import pytest


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
