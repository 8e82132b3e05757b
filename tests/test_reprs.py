"""What an object says of itself at the prompt: one line, with what a person needs."""

import pickle

import pytest

import flowabs_nodes as fa
from flowabs_nodes.engine.job import Job
from flowabs_nodes.engine.report import FrameReport, Report
from flowabs_nodes.errors import ReadError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.graph.shipped import paper, shipped
from flowabs_nodes.nodes import catalogue


def one_line(value, most=300):
    text = repr(value)
    assert "\n" not in text
    assert len(text) <= most, text
    return text


@pytest.mark.parametrize("name", [*shipped(), *paper()])
def test_a_graph(name):
    text = one_line(fa.load_graph(name), 400)
    assert text.startswith(f"<RunnableGraph {fa.load_graph(name).name!r}")
    assert " nodes, knobs: " in text


def test_a_graph_says_its_file_and_where_its_knobs_stand():
    graph = fa.load_graph("flat").with_set({"levels": 7})
    assert "flat.json: 7 nodes, knobs: simplify 0.5, levels 7, bands 0.5>" in one_line(graph)
    made = fa.load_graph({"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}}})
    assert one_line(made) == "<RunnableGraph '': 1 node, knobs: none>"
    assert repr(pickle.loads(pickle.dumps(Job(made.document, {"out": ("a.exr",)})))) == "<Job '' -> a.exr>"


def test_the_parts_of_a_graph():
    graph = fa.load_graph("lines")
    for value in (*graph.nodes.values(), *graph.interface.values()):
        one_line(value)
    assert repr(graph.nodes["pre"]) == "<GraphNode pre: fbl@1(image=broad.image, flow=flow.flow)>"
    assert repr(graph.interface["line_width"]) == "<Knob line_width = 1.0: a number from 0.5 to 2.5 (px)>"


def test_declarations():
    for node in catalogue().values():
        assert one_line(node).startswith(f"<Node {node.name}(")
        for param in node.params:
            assert one_line(param, 400).startswith(f"<Param {param.name}: ")


def test_a_report():
    done = FrameReport(1, "done", ("a.1.exr", "a.1.png"), 0.5)
    failed = FrameReport(2, "failed", ("a.2.exr",), 0.1, ReadError("is cut short", file="p.2.exr", frame=2))
    assert one_line(done) == "<FrameReport of frame 1: done, 0.50 s: a.1.exr, a.1.png>"
    assert one_line(failed) == "<FrameReport of frame 2: failed, 0.10 s: is cut short>"
    report = Report((done, failed), 1, 0.75)
    assert one_line(report) == "<Report of 2 frames: 1 done, 0 skipped, 1 failed, exit code 1, 0.75 s>"


def test_a_graph_error_is_one_line_too():
    with pytest.raises(GraphError) as caught:
        fa.load_graph({"format": "flowabs.graph/1", "nodes": {"a": {"type": "red@1"}}})
    assert "\n" not in repr(caught.value)
