"""effects.json: what a graph becomes as an effect."""

import json

import pytest

from flowabs_nodes.choices import readable
from flowabs_nodes.color import named
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.openfx import bundle, effects
from flowabs_nodes.openfx.effects import COLORSPACES, FORMAT, effect, effects_document
from tests.openfx.conftest import PANEL


@pytest.fixture
def folder(tmp_path):
    """Return a folder with the graph that has everything."""
    (tmp_path / "panel.json").write_text(json.dumps(PANEL))
    return tmp_path


def test_every_shipped_graph_is_one_effect():
    document, problems = effects_document([])
    assert problems == []
    assert document["format"] == FORMAT
    assert [each["identifier"] for each in document["effects"]] == [f"org.flowabs.{name}" for name in shipped()]
    assert all(each["label"] == f"Flowabs {readable(each['graph'])}" for each in document["effects"])
    assert json.loads(json.dumps(document)) == document


def test_graphs_of_ones_own_come_from_the_folders_of_the_variable(folder, monkeypatch, tmp_path):
    other = tmp_path / "more"
    other.mkdir()
    (other / "a b.json").write_text(json.dumps(PANEL))
    (other / "panel.json").write_text(json.dumps(PANEL))
    monkeypatch.setenv("FLOWABS_GRAPHS", f"{folder}:{other}:{tmp_path / 'nowhere'}")
    document, problems = effects_document()
    mine = [each for each in document["effects"] if ".user." in each["identifier"]]
    assert [(each["identifier"], each["graph"]) for each in mine] == [
        ("org.flowabs.user.panel", str(folder / "panel.json")),
        ("org.flowabs.user.a_b", str(other / "a b.json")),
    ]
    assert problems == [f"{other / 'panel.json'}: another graph is called 'panel' already"]


def test_a_graph_that_reads_nothing_or_is_wrong_is_said_to_be_no_effect(tmp_path):
    document = {
        "format": "flowabs.graph/1",
        "nodes": {"c": {"type": "constant@1"}, "out": {"type": "write@1", "inputs": {"image": "c"}}},
    }
    (tmp_path / "alone.json").write_text(json.dumps(document))
    (tmp_path / "bad.json").write_text("[1")
    found, problems = effects_document([tmp_path])
    assert len(found["effects"]) == len(shipped())
    assert len(problems) == 2
    assert "alone.json" in problems[0]
    assert "reads a picture" in problems[0]
    assert "bad.json" in problems[1]
    with pytest.raises(FlowabsError):
        effect("org.flowabs.user.bad", str(tmp_path / "bad.json"))


def test_there_are_no_more_effects_than_a_library_holds(folder, monkeypatch):
    source = (bundle.source_folder() / "effects.h").read_text(encoding="utf-8")
    assert f"MOST_EFFECTS = {effects.MOST_EFFECTS}" in source
    monkeypatch.setattr(effects, "MOST_EFFECTS", len(shipped()))
    document, problems = effects_document([folder])
    assert len(document["effects"]) == len(shipped())
    assert problems == [f"{folder / 'panel.json'}: a library holds {len(shipped())} effects at most"]


def test_clips_outputs_and_what_varies(folder):
    found = effect("org.flowabs.user.panel", str(folder / "panel.json"))
    assert found["plate"] == "plate"
    assert [(clip["name"], clip["given"], clip["channels"]) for clip in found["clips"]] == [
        ("other", "other", "RGBA"),
        ("depth", "depth", "R"),
    ]
    assert found["outputs"] == ["pick", "both", "inked", "far"]  # a flow is no picture to look at
    assert found["params"][0]["labels"] == ["Image", "Both", "Inked", "Far"]
    assert found["varies"] is True
    assert effect("org.flowabs.flat", "flat")["varies"] is False


@pytest.mark.parametrize(("name", "alone"), [("toon", True), ("steady_lines", True), ("outline", False)])
def test_a_graph_that_looks_at_other_frames_says_that_a_host_gives_it_one(name, alone):
    found = effect(f"org.flowabs.{name}", name)
    assert found["description"].endswith(effects.ALONE) == alone


def test_a_render_s_passes_are_clips():
    clips = {clip["given"]: clip["channels"] for clip in effect("org.flowabs.toon", "toon")["clips"]}
    ids = {"ids": "R", "ids.coverage": "R", "materials": "R"}
    assert clips == {"depth": "R", "normal": "RGB", **ids, "pass_motion": "RGBA"}


def test_parameters_of_a_group_stand_side_by_side_under_legal_names(folder):
    params = effect("org.flowabs.user.panel", str(folder / "panel.json"))["params"]
    names = [param["name"] for param in params]
    assert names == [
        *("output", "stops", "ink", "which", "how", "adaptive", "turned", "moving", "mix_knob"),
        *("mix", "colorspace", "colorspace_name"),
    ]
    groups = {param["name"]: (param["group"], param.get("group_label")) for param in params if param["group"]}
    assert groups["stops"] == groups["ink"] == ("group_A___B", "A & B")
    assert all(name.isidentifier() and name.isascii() for name in names)


def test_a_knob_that_moves_stands_at_its_first_value_and_says_so(folder):
    params = {p["name"]: p for p in effect("org.flowabs.user.panel", str(folder / "panel.json"))["params"]}
    assert (params["moving"]["default"], params["moving"]["curve"]) == (0, True)
    assert params["stops"]["curve"] is False


def test_every_colour_space_that_is_offered_is_one_that_is_known():
    assert list(COLORSPACES.values())[-1] == ""
    assert all(named.find(name).name for name in COLORSPACES.values() if name)
