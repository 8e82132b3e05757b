"""``flowabs check``."""

import json

import pytest


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


def test_a_parameter_that_does_nothing_exits_0(flowabs, tmp_path):
    ink = {"type": "dog@1", "inputs": {"image": "plate"}, "params": {"form": "xdog", "tau": 0.4}}
    code, out, _ = flowabs("check", graph_file(tmp_path, ink=ink, out=OUT | {"inputs": {"image": "ink"}}))
    assert code == 0
    assert out == (
        "unused-param (warning)  /nodes/ink/params/tau\n"
        '  found     tau 0.4, which does nothing beside form "xdog"\n'
        '  expected  form "paper" for tau\n'
        "  hint      leave tau out, or change what disables it\n\n"
        "ok, 1 warning\n"
    )


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


def test_displays_and_views_are_looked_up(flowabs, tmp_path):
    code, out, _ = flowabs("check", graph_file(tmp_path, out=OUT | {"params": {"view": "Rawr"}}))
    assert code == 2
    assert "bad-value  /nodes/out/params/view" in out
    assert "hint      did you mean 'Raw'?" in out
    assert flowabs("check", graph_file(tmp_path, out=OUT | {"params": {"view": "Raw"}})) == (0, "ok\n", "")
