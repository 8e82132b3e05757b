"""``flowabs colorspaces``, and names of colour spaces in ``flowabs check``."""

import json

import pytest

from flowabs_nodes.color.config import PINNED
from flowabs_nodes.color.spaces import SOURCES
from tests.studio import studio


@pytest.fixture
def show(tmp_path):
    return studio(tmp_path / "show")


def listed(flowabs, *arguments):
    code, out, err = flowabs("colorspaces", "--json", *arguments)
    assert (code, err) == (0, "")
    return json.loads(out)


def test_the_pinned_config(flowabs):
    found = listed(flowabs)
    assert found["config"] == PINNED
    ours = {each["name"]: each for each in found["flowabs"]}
    assert ours["lin_rec709"]["aliases"] == list(SOURCES["lin_rec709"][1])
    assert {*SOURCES, "sRGB", "cineon", "data"} == set(ours)
    spaces = {each["name"]: each for each in found["spaces"]}
    assert spaces["ACEScg"]["family"] == "ACES"
    assert "lin_ap1" in spaces["ACEScg"]["aliases"]
    assert spaces["Raw"]["encoding"] == "data"
    assert found["roles"]["scene_linear"] == "ACEScg"
    assert "Un-tone-mapped" in found["displays"][found["default_display"]]
    assert found["default_view"] in found["displays"][found["default_display"]]


def test_linear_spaces_are_marked(flowabs):
    pytest.importorskip("OpenImageIO", minversion="3.1")
    spaces = {each["name"]: each["scene_linear"] for each in listed(flowabs)["spaces"]}
    assert spaces["ACEScg"]
    assert spaces["Linear ARRI Wide Gamut 4"]
    assert not any(spaces[name] for name in ("ACEScct", "sRGB - Display", "CIE XYZ-D65 - Display-referred", "Raw"))


def test_a_studio_s_config(flowabs, show, monkeypatch):
    monkeypatch.setenv("OCIO", show)
    found = listed(flowabs)
    assert found["config"] == show
    spaces = {each["name"]: each for each in found["spaces"]}
    assert set(spaces) == {"house_reference", "bytes", "show_lin", "show_log", "show_film", "sRGB"}
    assert spaces["show_log"] | {"scene_linear": None} == {
        "name": "show_log",
        "family": "Show",
        "encoding": "log",
        "aliases": [],
        "scene_linear": None,
    }
    assert spaces["show_lin"]["aliases"] == ["plate_lin"]
    assert found["displays"] == {"monitor": ["Film", "Raw"]}
    assert "sRGB" not in {each["name"] for each in found["flowabs"]}  # the config's own
    assert found == listed(flowabs, "--ocio", show)


def test_for_people(flowabs, show):
    code, out, _ = flowabs("colorspaces", "--ocio", show)
    assert code == 0
    assert out.startswith(f"colour config {show}, from the option ocio\n")
    lines = [" ".join(line.split()) for line in out.splitlines()]
    assert "lin_ap1_scene scene-linear lin_ap1, ACEScg, ACES - ACEScg" in lines
    assert "show_log log" in lines
    assert "scene_linear show_lin" in lines
    assert "monitor * Film *, Raw" in lines
    assert all(len(line) <= 120 for line in out.splitlines())
    assert flowabs("colorspaces")[1].startswith(f"colour config {PINNED}, the built-in one\n")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("show_log", {"kind": "encoded", "linear_space": "lin_ap1_scene", "family": "Show"}),
        ("scene_linear", {"name": "show_lin", "kind": "linear", "linear_space": "lin_ap1_scene"}),
        ("lin_rec709", {"kind": "linear", "linear_space": "lin_rec709", "config": None}),
        ("acescg", {"kind": "linear", "linear_space": "lin_ap1_scene", "config": None}),
        ("ACEScct", {"kind": "encoded", "config": PINNED}),
        ("bytes", {"kind": "data", "linear_space": None}),
    ],
)
def test_one_name(flowabs, show, name, expected):
    found = listed(flowabs, "--ocio", show, name)
    assert {key: found[key] for key in expected} == expected
    code, out, _ = flowabs("colorspaces", "--ocio", show, name)
    assert code == 0
    assert out.splitlines()[0] == found["name"]


def test_a_typo(flowabs, show):
    code, out, err = flowabs("colorspaces", "--ocio", show, "show_lgo")
    assert (code, out) == (2, "")
    assert "did you mean 'show_log'?" in err


@pytest.mark.parametrize(
    "command", [["colorspaces"], ["check", "lines"], ["run", "lines", "-i", "a.exr", "-o", "b.exr"]]
)
def test_a_config_that_is_not_there(flowabs, monkeypatch, tmp_path, command):
    monkeypatch.chdir(tmp_path)
    code, out, err = flowabs(*command, "--ocio", "no/such.ocio")
    assert (code, out) == (2, "")
    assert "the OCIO config 'no/such.ocio' cannot be read: no such file" in err
    monkeypatch.setenv("OCIO", "other/such.ocio")
    code, out, err = flowabs(*command)
    assert (code, out) == (2, "")
    assert "the OCIO config 'other/such.ocio' cannot be read: no such file (it is what $OCIO says" in err


# ---------------------------------------------------------------------- flowabs check


def graph_file(tmp_path, space, knob=False):
    path = tmp_path / "graph.json"
    nodes = {
        "plate": {"type": "read@1", "params": {"colorspace": {"from": "space"} if knob else space}},
        "out": {"type": "write@1", "inputs": {"image": "plate"}},
    }
    interface = {"interface": {"space": {"type": "string", "default": space}}} if knob else {}
    path.write_text(json.dumps({"format": "flowabs.graph/1", **interface, "nodes": nodes}))
    return path


def test_check_knows_the_names_of_the_config(flowabs, tmp_path, show):
    path = graph_file(tmp_path, "show_log")
    assert flowabs("check", path, "--ocio", show) == (0, f"colour config {show}, from the option ocio\n\nok\n", "")
    code, out, _ = flowabs("check", path)
    assert code == 2
    assert "bad-value  /nodes/plate/params/colorspace" in out
    assert '"show_log"' in out


@pytest.mark.parametrize(
    ("knob", "place"), [(False, "/nodes/plate/params/colorspace"), (True, "/interface/space/default")]
)
def test_check_gives_the_nearest_name(flowabs, tmp_path, show, monkeypatch, knob, place):
    monkeypatch.setenv("OCIO", show)
    code, out, _ = flowabs("check", "--json", graph_file(tmp_path, "show_lgo", knob))
    assert code == 2
    (problem,) = json.loads(out)["problems"]
    assert problem == {
        "code": "bad-value",
        "pointer": place,
        "found": '"show_lgo"',
        "expected": f"a colour space of {show}",
        "hint": "did you mean 'show_log'?",
    }


def test_check_finds_a_table_that_is_missing(flowabs, tmp_path):
    show = studio(tmp_path / "show", gain=None)
    code, out, _ = flowabs("check", graph_file(tmp_path, "show_film"), "--ocio", show)
    assert code == 2
    assert "film.cube" in out
    assert flowabs("check", graph_file(tmp_path, "show_log"), "--ocio", show)[0] == 0
