"""What a host is told of a graph: enough for a panel, and for the pictures that go in and come out."""

import json
import os

import pytest

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph.shipped import paper, shipped
from flowabs_nodes.serve.describing import described
from tests.serve.wire import document, graph_file


def write(folder, content):
    path = folder / "graph.json"
    path.write_text(json.dumps(content))
    return str(path)


def test_a_graph_is_described_with_knobs_inputs_and_outputs(graph):
    told = described(graph, {}, 1)
    assert told == {
        "name": "bright",
        "description": "Brighter.",
        "knobs": [
            {
                "name": "stops",
                "type": "float",
                "label": "Stops",
                "group": "",
                "value": 1.0,
                "default": 1.0,
                "min": -5,
                "max": 5,
                "unit": "",
                "help": "Stops.",
                "choices": (),
                "animated": False,
                "enabled": True,
            }
        ],
        "inputs": [{"node": "plate", "output": "image", "type": "color", "optional": False, "label": "Plate"}],
        "outputs": [{"name": "bright", "type": "color"}],
        "file": graph,
        "changed": os.stat(graph).st_mtime,
    }


@pytest.mark.parametrize("name", [*shipped(), *paper()])
def test_every_shipped_graph_can_be_described_as_json(name):
    told = json.loads(json.dumps(described(name, {}, 1), allow_nan=False))
    assert told["name"]
    assert told["inputs"][0]["type"] == "color"
    assert all(each["type"] in ("color", "mono", "matte", "flow") for each in told["outputs"])
    assert all(each["label"] and each["help"] for each in told["knobs"])


def test_knobs_stand_where_they_are_set(graph):
    knob = described(graph, {"stops": {"curve": {"1": 0, "11": 5}}}, 5)["knobs"][0]
    assert (knob["value"], knob["default"], knob["animated"]) == (2.0, 1.0, True)
    with pytest.raises(FlowabsError, match="did you mean 'stops'"):
        described(graph, {"stop": 1}, 1)


def test_the_plate_is_the_first_read_and_what_has_a_file_is_optional(tmp_path):
    content = document()
    content["nodes"] = {
        "far": {"type": "read_depth@1", "params": {"file": "z.exr"}},
        "tags": {"type": "read_id@1"},
        **content["nodes"],
        "other": {"type": "read@1", "params": {"file": "other.exr"}},
        "out": {"type": "write@1", "inputs": {"image": "bright", "z": "far", "t": "tags.coverage", "o": "other"}},
    }
    told = described(write(tmp_path, content), {}, 1)
    assert [
        (each["node"], each["output"], each["type"], each["optional"], each["label"]) for each in told["inputs"]
    ] == [
        ("plate", "image", "color", False, "Plate"),
        ("other", "image", "color", True, "Other"),
        ("far", "depth", "depth", True, "Far"),
        ("tags", "coverage", "mono", False, "Tags coverage"),
    ]
    assert told["outputs"] == [
        {"name": "bright", "type": "color"},
        {"name": "far", "type": "depth"},
        {"name": "tags.coverage", "type": "mono"},
        {"name": "other", "type": "color"},
    ]


def test_a_long_chain_without_a_write_has_the_output_of_its_end(tmp_path):
    content = document()
    nodes = {"plate": content["nodes"]["plate"]}
    for number in range(3000):
        before = f"n{number - 1}" if number else "plate"
        nodes[f"n{number}"] = {"type": "exposure@1", "inputs": {"image": before}}
    told = described(write(tmp_path, {**content, "nodes": nodes, "interface": {}}), {}, 1)
    assert told["outputs"] == [{"name": "n2999", "type": "color"}]


def test_a_graph_that_is_wrong_is_an_error(tmp_path):
    with pytest.raises(FlowabsError, match="did you mean 'abstraction'"):
        described("abstracton", {}, 1)
    with pytest.raises(FlowabsError, match="unknown-type"):
        described(graph_file(tmp_path, type="exposur@1"), {}, 1)
