import json
from pathlib import Path

import pytest

from flowabs_nodes import graph
from flowabs_nodes.errors import CommandError
from flowabs_nodes.graph.reference_size import ReferenceSize
from tests.graph.fakes import CATALOGUE, document


def test_all_kinds_of_sources_give_the_same_graph(tmp_path):
    path = tmp_path / "toon.json"
    path.write_text(json.dumps(document()), encoding="utf-8")
    loaded = [
        graph.load(source, CATALOGUE) for source in (document(), json.dumps(document()).encode(), path, str(path))
    ]
    assert all(each.document == document() for each in loaded)
    assert [each.source for each in loaded] == ["", "", str(path), str(path)]
    assert loaded[0].name == "toon"
    assert loaded[0].reference_size == ReferenceSize("height", 1080)
    assert loaded[0].ui == document()["ui"]


def test_the_document_goes_round_through_json():
    loaded = graph.load(document(), CATALOGUE)
    again = graph.load(json.loads(json.dumps(loaded.document)), CATALOGUE)
    assert again.document == loaded.document
    assert again.values(1005) == loaded.values(1005)


def test_loading_leaves_the_dict_it_was_given_alone():
    source = document()
    graph.load(source, CATALOGUE).document["name"] = "other"
    assert source == document()


def test_nodes_come_after_those_they_need():
    backwards = document(nodes=dict(reversed(document()["nodes"].items())))
    names = list(graph.load(backwards, CATALOGUE).nodes)
    for name, node in graph.load(backwards, CATALOGUE).nodes.items():
        assert all(names.index(link.node) < names.index(name) for link in node.inputs.values())


def test_a_link_without_an_output_is_to_the_first():
    inputs = graph.load(document(), CATALOGUE).nodes["toon"].inputs
    assert inputs == {
        "image": graph.Link("plate", "image"),
        "lines": graph.Link("soft", "image"),
        "mask": graph.Link("drawing", "lines"),
    }


def test_an_invalid_graph_raises_everything_at_once():
    broken = document(nane="x", reference_height=-1)
    with pytest.raises(graph.GraphError) as caught:
        graph.load(broken, CATALOGUE)
    assert list(caught.value.problems) == graph.check(broken, CATALOGUE)
    assert [problem.code for problem in caught.value.problems] == ["unknown-key", "out-of-range"]
    assert "2 problems" in str(caught.value)
    assert "did you mean 'name'?" in str(caught.value)
    assert caught.value.to_dict()["problems"][0]["pointer"] == "/nane"


def test_a_bom_is_let_pass_and_utf16_is_not():
    text = json.dumps(document())
    assert graph.load(b"\xef\xbb\xbf" + text.encode(), CATALOGUE).name == "toon"
    assert [problem.code for problem in graph.check(text.encode("utf-16"), CATALOGUE)] == ["bad-json"]


@pytest.mark.parametrize("name", ["no/such.json", "nothere.json", ".", "a\0b.json"])
def test_a_file_that_cannot_be_read_is_named(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(CommandError) as caught:
        graph.load(name if name != "." else str(tmp_path) + "/", CATALOGUE)
    assert caught.value.file


def test_python_data_becomes_plain_data():
    numpy = pytest.importorskip("numpy")
    changed = document()
    changed["nodes"]["field"]["params"] = {"iterations": numpy.int64(4), "radius": numpy.float32(2.5)}
    changed["nodes"]["toon"]["params"] = {"ink": (1, 0, 0)}
    changed["nodes"]["drawing"]["params"] = {"sigma": {"curve": {1: 1.0, 3: 2.0}}}
    values = graph.load(changed, CATALOGUE).values(2)
    assert values["field"]["iterations"] == 4
    assert values["field"]["radius"] == 2.5
    assert values["toon"]["ink"] == (1.0, 0.0, 0.0)
    assert values["drawing"]["sigma"] == 1.5


def test_python_data_that_is_no_json_is_refused():
    circle = document()
    circle["ui"]["self"] = circle
    deep: list = []
    for _ in range(100_000):
        deep = [deep]
    for source in (circle, document(ui={"x": object()}), document(ui={("a", "b"): 1}), document(ui={"deep": deep})):
        (problem,) = graph.check(source, CATALOGUE)
        assert problem.code in ("wrong-type", "too-big")
    (problem,) = graph.check(document(reference_height=float("nan")), CATALOGUE)
    assert (problem.code, problem.pointer) == ("bad-json", "/reference_height")


@pytest.mark.parametrize("source", ["~/g.json", "$SHOW/g.json", "a/%SHOW%.json", Path("~/g.json"), "$(pwd)/g.json"])
def test_a_path_that_only_a_shell_understands_has_a_hint(source):
    with pytest.raises(CommandError) as caught:
        graph.load(source)
    assert caught.value.code == "bad-path"
    assert caught.value.hint


def test_the_file_of_a_graph_that_comes_with_flowabs_is_known_by_its_name():
    with pytest.raises(CommandError, match=r"lines\.json.*\(the graph that comes with flowabs is 'lines'\)"):
        graph.load("lines.json")
    with pytest.raises(CommandError) as caught:
        graph.load("mine.json")
    assert caught.value.hint == ""
