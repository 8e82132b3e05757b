"""Each mistake has its code, its place, and is said once."""

import dataclasses
import json

import jsonschema
import pytest

from flowabs_nodes import graph
from flowabs_nodes.nodes.declare import Param, Port
from tests.graph.fakes import CATALOGUE, document, nodes

LINES = {"type": "lines@1", "inputs": {"image": "plate", "flow": "field"}}
FIELD = {"type": "flow@1", "inputs": {"image": "plate"}}


def found(source) -> list[tuple[str, str]]:
    return [(problem.code, problem.pointer) for problem in graph.check(source, CATALOGUE)]


def only(source) -> graph.Problem:
    (problem,) = graph.check(source, CATALOGUE)
    return problem


def with_params(**params):
    return nodes(field=FIELD | {"params": params})


def test_a_good_graph_has_no_problems():
    assert found(document()) == []
    assert found({"format": "flowabs.graph/1", "nodes": {}}) == []


def test_ten_mistakes_are_ten_problems():
    broken = document(nane="toon")  # 1
    broken["interface"]["calm"]["max"] = "high"  # 2
    broken["nodes"]["plate"]["type"] = "raed@1"  # 3
    broken["nodes"]["field"]["params"]["radius"] = 1000  # 4
    broken["nodes"]["field"]["params"]["kernel"] = "ful"  # 5
    broken["nodes"]["drawing"]["inputs"]["flow"] = "feild"  # 6
    broken["nodes"]["drawing"]["params"]["sigm"] = 2  # 7
    broken["nodes"]["soft"]["inputs"] = {"image": "drawing.line"}  # 8
    broken["nodes"]["toon"]["inputs"]["lines"] = "field"  # 9
    del broken["nodes"]["out"]["inputs"]["image"]  # 10
    problems = graph.check(broken, CATALOGUE)
    assert [(problem.code, problem.pointer, problem.hint) for problem in problems] == [
        ("unknown-key", "/nane", "did you mean 'name'?"),
        ("wrong-type", "/interface/calm/max", ""),
        ("unknown-type", "/nodes/plate/type", "did you mean 'read@1'?"),
        ("out-of-range", "/nodes/field/params/radius", ""),
        ("bad-value", "/nodes/field/params/kernel", "did you mean 'full'?"),
        ("unknown-param", "/nodes/drawing/params/sigm", "did you mean 'sigma'?"),
        ("unknown-node", "/nodes/drawing/inputs/flow", "did you mean 'field'?"),
        ("unknown-output", "/nodes/soft/inputs/image", "did you mean 'lines'?"),
        ("missing-input", "/nodes/out/inputs/image", ""),
        ("wrong-type", "/nodes/toon/inputs/lines", ""),
    ]
    assert all(problem.found and problem.expected for problem in problems)


@pytest.mark.parametrize(
    ("change", "code", "pointer"),
    [
        ({"format": "flowabs.graph/2"}, "newer-version", "/format"),
        ({"format": "flowabs.graph/0"}, "bad-value", "/format"),
        ({"format": 1}, "bad-value", "/format"),
        ({"description": 1}, "wrong-type", "/description"),
        ({"reference_height": 0}, "out-of-range", "/reference_height"),
        ({"reference_height": True}, "wrong-type", "/reference_height"),
        ({"reference_size": 540}, "wrong-type", "/reference_size"),
        ({"reference_size": {}}, "bad-value", "/reference_size"),
        ({"reference_size": {"height": 540, "width": 960}}, "bad-value", "/reference_size"),
        ({"reference_size": {"shortr": 540}}, "unknown-key", "/reference_size/shortr"),
        ({"reference_size": {"shorter": "540"}}, "wrong-type", "/reference_size/shorter"),
        ({"reference_size": {"diagonal": 0}}, "out-of-range", "/reference_size/diagonal"),
        ({"reference_size": {"height": 540}, "reference_height": 540}, "bad-value", "/reference_size"),
        ({"interface": []}, "wrong-type", "/interface"),
        ({"nodes": []}, "wrong-type", "/nodes"),
        ({"ui": []}, "wrong-type", "/ui"),
        ({"$schema": 1}, "wrong-type", "/$schema"),
    ],
)
def test_the_top_of_the_file(change, code, pointer):
    source = {"format": "flowabs.graph/1", "nodes": {}} | change
    assert found(source) == [(code, pointer)]


@pytest.mark.parametrize("key", ["format", "nodes"])
def test_what_has_to_be_there(key):
    source = {"format": "flowabs.graph/1", "nodes": {}}
    del source[key]
    assert found(source) == [("bad-value", f"/{key}")]


def test_a_key_with_a_slip_is_not_also_missing():
    assert found({"format": "flowabs.graph/1", "node": {}}) == [("unknown-key", "/node")]
    assert found(nodes(a={"typ": "read@1"})) == [("unknown-key", "/nodes/a/typ")]


# ---------------------------------------------------------------------- nodes and their types


@pytest.mark.parametrize(
    ("node", "code", "pointer"),
    [
        ([], "wrong-type", ""),
        ({}, "bad-value", "/type"),
        ({"type": 1}, "wrong-type", "/type"),
        ({"type": ""}, "unknown-type", "/type"),
        ({"type": "nothing_like_it@1"}, "unknown-type", "/type"),
        ({"type": "read"}, "unknown-type", "/type"),
        ({"type": "read@0"}, "unknown-type", "/type"),
        ({"type": "read@x"}, "unknown-type", "/type"),
        ({"type": "read@2"}, "newer-version", "/type"),
        ({"type": "read@1", "inputs": []}, "wrong-type", "/inputs"),
        ({"type": "read@1", "params": []}, "wrong-type", "/params"),
        ({"type": "read@1", "pos": [0, 0]}, "unknown-key", "/pos"),
    ],
)
def test_a_node(node, code, pointer):
    assert found(nodes(a=node)) == [(code, "/nodes/a" + pointer)]


def test_the_type_without_a_version_gets_it_as_a_hint():
    assert only(nodes(a={"type": "read"})).hint == "did you mean 'read@1'?"


def test_a_node_of_unknown_type_is_one_problem():
    broken = nodes(
        field={"type": "flwo@1", "inputs": {"nothing": "plate"}, "params": {"anything": 1}},
        drawing=LINES | {"inputs": {"image": "plate", "flow": "field.whatever"}},
        out={"type": "write@1", "inputs": {"image": "drawing"}},
    )
    assert found(broken) == [("unknown-type", "/nodes/field/type")]


@pytest.mark.parametrize("name", ["my node", "1st", "", "a-b", "a.b", "ä", "x" * 129, "x\n"])
def test_names(name):
    problem = only({"format": "flowabs.graph/1", "nodes": {name: {"type": "read@1"}}})
    assert (problem.code, problem.pointer) == ("bad-value", f"/nodes/{name}")
    problem = only({"format": "flowabs.graph/1", "nodes": {}, "interface": {name: {"type": "bool", "default": True}}})
    assert (problem.code, problem.pointer) == ("bad-value", f"/interface/{name}")


def test_a_bad_name_can_still_be_linked_to():
    broken = nodes(**{"my field": FIELD}, drawing=LINES | {"inputs": {"image": "plate", "flow": "my field"}})
    assert found(broken) == [("bad-value", "/nodes/my field")]


def test_pointers_are_escaped():
    assert found({"format": "flowabs.graph/1", "nodes": {"a/b~c": {"type": "read@1"}}}) == [
        ("bad-value", "/nodes/a~1b~0c")
    ]


# ---------------------------------------------------------------------- links


@pytest.mark.parametrize(
    ("inputs", "code", "pointer"),
    [
        ({"image": "plat"}, "unknown-node", "image"),
        ({"image": ""}, "unknown-node", "image"),
        ({"image": "plate."}, "unknown-output", "image"),
        ({"image": "plate.picture"}, "unknown-output", "image"),
        ({"image": "out"}, "unknown-output", "image"),
        ({"image": None}, "wrong-type", "image"),
        ({"image": ["plate", "image"]}, "wrong-type", "image"),
        ({}, "missing-input", "image"),
        ({"imag": "plate"}, "unknown-input", "imag"),
        ({"image": "plate", "nothing": "plate"}, "unknown-input", "nothing"),
        ({"image": "depth"}, "wrong-type", "image"),
        ({"image": "field"}, "cycle", "image"),
        ({"image": "plate", "mask": "plate"}, "unknown-input", "mask"),
    ],
)
def test_links(inputs, code, pointer):
    source = nodes(
        depth={"type": "read_aov@1"},
        field={"type": "flow@1", "inputs": inputs},
        out={"type": "write@1", "inputs": {"image": "field", "a": "plate", "depth": "depth"}},
    )
    assert found(source) == [(code, f"/nodes/field/inputs/{pointer}")]


def test_an_input_that_needs_another_one():
    edges = (Port("strength", "mono", ".", optional=True, beside="along"), Port("along", "flow", ".", optional=True))
    flow = dataclasses.replace(CATALOGUE["flow"], inputs=(*CATALOGUE["flow"].inputs, *edges))
    alone = nodes(field={"type": "flow@1", "inputs": {"image": "plate", "strength": "drawing.response"}})
    alone["nodes"]["drawing"] = {"type": "lines@1", "inputs": {"image": "plate", "flow": "other"}}
    alone["nodes"]["other"] = {"type": "flow@1", "inputs": {"image": "plate"}}
    problems = [each for each in graph.check(alone, CATALOGUE | {"flow": flow}) if not each.warning]
    assert [(each.code, each.pointer) for each in problems] == [("missing-input", "/nodes/field/inputs/along")]
    assert "strength" in problems[0].expected


def test_a_wrong_input_name_stands_for_one_open_input_only():
    source = nodes(field=FIELD, drawing={"type": "lines@1", "inputs": {"imgae": "plate"}})
    assert found(source) == [
        ("unknown-input", "/nodes/drawing/inputs/imgae"),
        ("missing-input", "/nodes/drawing/inputs/flow"),
    ]


def test_port_types_go_through_nodes_that_keep_them():
    blur = {"type": "blur@1", "inputs": {"image": "drawing.response"}}
    soft = {"type": "blur@1", "inputs": {"image": "one"}}
    comp = {"type": "comp@1", "inputs": {"image": "two", "lines": "two"}}
    problem = only(nodes(field=FIELD, drawing=LINES, one=blur, two=soft, toon=comp))
    assert (problem.code, problem.pointer) == ("wrong-type", "/nodes/toon/inputs/lines")
    assert (problem.found, problem.expected) == ("two.image, which is mono", "matte")


def test_one_that_does_not_fit_is_not_said_again_behind_it():
    source = nodes(
        field=FIELD,
        one={"type": "blur@1", "inputs": {"image": "field"}},
        two={"type": "flow@1", "inputs": {"image": "one"}},
    )
    assert found(source) == [("wrong-type", "/nodes/one/inputs/image")]


def test_the_other_output_is_the_hint():
    source = nodes(
        field=FIELD, drawing=LINES, toon={"type": "comp@1", "inputs": {"image": "plate", "lines": "drawing.response"}}
    )
    assert only(source).hint == "did you mean 'drawing.lines'?"


def test_layers_take_anything_under_a_good_name():
    inputs = {"image": "plate", "flow": "field", "my layer": "plate", "file": "plate"}
    source = nodes(field=FIELD, out={"type": "write@1", "inputs": inputs})
    assert found(source) == [("bad-value", "/nodes/out/inputs/my layer"), ("bad-value", "/nodes/out/inputs/file")]


def test_every_cycle_is_one_problem():
    ring = {name: {"type": "blur@1", "inputs": {"image": source}} for name, source in zip("abc", "bca", strict=True)}
    pair = {
        "x": {"type": "comp@1", "inputs": {"image": "a", "lines": "y"}},
        "y": {"type": "blur@1", "inputs": {"image": "x"}},
        "self": {"type": "blur@1", "inputs": {"image": "self"}},
        "after": {"type": "blur@1", "inputs": {"image": "y"}},
    }
    problems = graph.check(nodes(**ring, **pair), CATALOGUE)
    assert {problem.code for problem in problems} == {"cycle"}
    assert sorted(set(problem.found.split(" -> ")) for problem in problems) == sorted([set("abc"), set("xy"), {"self"}])
    for problem in problems:
        first, *_, last = problem.found.split(" -> ")
        assert first == last


def test_what_no_file_needs_is_a_warning():
    source = nodes(
        field=FIELD,
        drawing=LINES,
        out={"type": "write@1", "inputs": {"image": "plate"}},
    )
    problems = graph.check(source, CATALOGUE)
    assert [(problem.code, problem.pointer, problem.warning) for problem in problems] == [
        ("unused-node", "/nodes/field", True),
        ("unused-node", "/nodes/drawing", True),
    ]
    assert graph.load(source, CATALOGUE).warnings == tuple(problems)
    assert found(nodes(field=FIELD)) == []  # for Python: what nothing takes is an output


def test_a_broken_link_does_not_make_its_node_unused():
    source = nodes(field=FIELD, drawing=LINES, out={"type": "write@1", "inputs": {"image": "drawin"}})
    assert found(source) == [("unknown-node", "/nodes/out/inputs/image")]


# ---------------------------------------------------------------------- parameters


@pytest.mark.parametrize(
    ("param", "value", "code"),
    [
        ("radius", "5", "wrong-type"),
        ("radius", True, "wrong-type"),
        ("radius", None, "wrong-type"),
        ("radius", [5], "wrong-type"),
        ("radius", -0.1, "out-of-range"),
        ("radius", 100.1, "out-of-range"),
        ("radius", 10**200, "out-of-range"),
        ("iterations", 1.0, "wrong-type"),
        ("iterations", True, "wrong-type"),
        ("iterations", 11, "out-of-range"),
        ("kernel", "half", "bad-value"),
        ("kernel", 1, "wrong-type"),
        ("color", 1, "wrong-type"),
        ("color", "true", "wrong-type"),
        ("reference", "p", "bad-value"),
        ("reference", {"a": 1}, "bad-value"),
        ("mix", 0.5, "unknown-param"),
    ],
)
def test_literals(param, value, code):
    assert found(with_params(**{param: value})) == [(code, f"/nodes/field/params/{param}")]


def test_the_end_of_an_open_range_is_outside():
    assert found(nodes(field=FIELD, drawing=LINES | {"params": {"sigma": 0}})) == [
        ("out-of-range", "/nodes/drawing/params/sigma")
    ]
    assert found(nodes(field=FIELD, drawing=LINES | {"params": {"contrast": None}})) == []


@pytest.mark.parametrize("ink", [[0, 0], [0, 0, 0, 1], [0, 0, "0"], [0, 0, True], "black", 0])
def test_colors(ink):
    source = nodes(
        field=FIELD, drawing=LINES, toon={"type": "comp@1", "inputs": {"image": "plate", "lines": "drawing"}}
    )
    source["nodes"]["toon"]["params"] = {"ink": ink}
    assert found(source) == [("wrong-type", "/nodes/toon/params/ink")]


def test_a_number_for_a_text_wants_quotes():
    problem = only(nodes(a={"type": "read@1", "params": {"layer": 2}}))
    assert (problem.code, problem.hint) == ("wrong-type", 'a text stands in quotes: "2"')


def test_required_parameters():
    needy = {"type": "needy@1", "inputs": {"image": "plate"}}
    assert found(nodes(a=needy)) == [("missing-param", "/nodes/a/params/amount")]
    assert found(nodes(a=needy | {"params": {"amont": 1}})) == [("unknown-param", "/nodes/a/params/amont")]
    assert found(nodes(a=needy | {"params": {"amount": 1}})) == []
    assert found(nodes(out={"type": "write@1", "inputs": {"image": "plate"}})) == []  # a file may be set by the run


@pytest.mark.parametrize(
    ("value", "code", "pointer"),
    [
        ({}, "bad-value", ""),
        ({"form": "calm"}, "unknown-key", "/form"),
        ({"from": 1}, "wrong-type", "/from"),
        ({"from": "clam"}, "unknown-param", "/from"),
        ({"from": "words"}, "wrong-type", "/from"),
        ({"from": "all"}, "wrong-type", "/from"),
        ({"from": "calm", "curve": {"1": 1}}, "bad-value", ""),
        ({"curve": {"1": 1}, "map": [[0, 0], [1, 1]]}, "unknown-key", "/map"),
        ({"map": [[0, 0], [1, 1]]}, "bad-value", ""),
        ({"from": "calm", "scale": 2}, "unknown-key", "/scale"),
        ({"from": "calm", "map": {}}, "wrong-type", "/map"),
        ({"from": "calm", "map": []}, "bad-value", "/map"),
        ({"from": "calm", "map": [[0, 1]]}, "bad-value", "/map"),
        ({"from": "calm", "map": [[0, 1], [0, 2]]}, "bad-value", "/map/1/0"),
        ({"from": "calm", "map": [[1, 1], [0, 2]]}, "bad-value", "/map/1/0"),
        ({"from": "calm", "map": [[0, 1], [1]]}, "wrong-type", "/map/1"),
        ({"from": "calm", "map": [[0, 1], ["1", 2]]}, "wrong-type", "/map/1"),
        ({"from": "calm", "map": [[0, 1], [1, None]]}, "wrong-type", "/map/1/1"),
        ({"from": "calm", "map": [[0, 1], [1, 1000]]}, "out-of-range", "/map/1/1"),
        ({"from": "how", "map": [[0, 1], [1, 2]]}, "wrong-type", "/from"),
        ({"curve": []}, "wrong-type", "/curve"),
        ({"curve": {}}, "bad-value", "/curve"),
        ({"curve": {"1001": "5"}}, "wrong-type", "/curve/1001"),
        ({"curve": {"1001": None}}, "wrong-type", "/curve/1001"),
        ({"curve": {"1001": -1}}, "out-of-range", "/curve/1001"),
        ({"curve": {"first": 1}}, "bad-value", "/curve/first"),
        ({"curve": {"01": 1}}, "bad-value", "/curve/01"),
        ({"curve": {"1.5": 1}}, "bad-value", "/curve/1.5"),
        ({"curve": {"9" * 5000: 1}}, "bad-value", "/curve/" + "9" * 5000),
    ],
)
def test_knobs_and_curves(value, code, pointer):
    source = with_params(radius=value) | {"interface": document()["interface"]}
    assert found(source) == [(code, "/nodes/field/params/radius" + pointer)]


def test_only_numbers_take_maps_and_curves():
    for param in ("kernel", "color", "reference"):
        for value, where in (({"curve": {"1": 1}}, "curve"), ({"from": "calm", "map": [[0, 1], [1, 2]]}, "map")):
            source = with_params(**{param: value}) | {"interface": document()["interface"]}
            assert found(source) == [("wrong-type", f"/nodes/field/params/{param}/{where}")]


def test_whole_numbers_are_whole_in_curves_and_maps_too():
    assert found(with_params(iterations={"curve": {"1": 1.5}})) == [
        ("wrong-type", "/nodes/field/params/iterations/curve/1")
    ]
    mapped = with_params(iterations={"from": "calm", "map": [[0, 0.5], [1, 2]]}) | {
        "interface": document()["interface"]
    }
    assert found(mapped) == [("wrong-type", "/nodes/field/params/iterations/map/0/1")]


# ---------------------------------------------------------------------- knobs


@pytest.mark.parametrize(
    ("knob", "code", "pointer"),
    [
        ([], "wrong-type", ""),
        ({"type": "float"}, "bad-value", "/default"),
        ({"default": 1}, "bad-value", "/type"),
        ({"type": "flaot", "default": 1}, "bad-value", "/type"),
        ({"type": "file", "default": "a"}, "bad-value", "/type"),
        ({"type": "float", "default": "1"}, "wrong-type", "/default"),
        ({"type": "float", "default": 2, "max": 1}, "out-of-range", "/default"),
        ({"type": "float", "default": 2, "min": 3, "max": 1}, "bad-value", "/max"),
        ({"type": "float", "default": 2, "min": "1"}, "wrong-type", "/min"),
        ({"type": "int", "default": 1.0}, "wrong-type", "/default"),
        ({"type": "int", "default": 1, "min": 0.5}, "wrong-type", "/min"),
        ({"type": "bool", "default": 1}, "wrong-type", "/default"),
        ({"type": "bool", "default": True, "min": 0}, "unknown-key", "/min"),
        ({"type": "string", "default": "a", "choices": ["a"]}, "unknown-key", "/choices"),
        ({"type": "string", "default": 1}, "wrong-type", "/default"),
        ({"type": "enum", "default": "a"}, "bad-value", "/choices"),
        ({"type": "enum", "default": "a", "choices": []}, "bad-value", "/choices"),
        ({"type": "enum", "default": "a", "choices": ["a", 1]}, "bad-value", "/choices"),
        ({"type": "enum", "default": "a", "choices": ["a", "a"]}, "bad-value", "/choices"),
        ({"type": "enum", "default": "c", "choices": ["a", "b"]}, "bad-value", "/default"),
        ({"type": "color", "default": [0, 0]}, "wrong-type", "/default"),
        ({"type": "float", "default": 1, "lable": "Width"}, "unknown-key", "/lable"),
        ({"type": "float", "default": 1, "help": 1}, "wrong-type", "/help"),
    ],
)
def test_a_knob(knob, code, pointer):
    source = with_params(radius={"from": "knob"}) | {"interface": {"knob": knob}}
    assert found(source) == [(code, "/interface/knob" + pointer)]


def test_what_a_panel_shows_of_a_knob():
    def param(**about):
        knobs = {"line_width": {"type": "float", "default": 2} | about}
        source = with_params(radius={"from": "line_width"}) | {"interface": knobs}
        return graph.load(source, CATALOGUE).interface["line_width"].param

    assert (param().label, param().group) == ("Line width", "")
    assert (param(label="Ink", group="Lines").label, param(label="Ink", group="Lines").group) == ("Ink", "Lines")
    for key in ("label", "group"):
        wrong = {"interface": {"knob": {"type": "float", "default": 2, key: 3}}}
        assert found(with_params(radius={"from": "knob"}) | wrong) == [("wrong-type", f"/interface/knob/{key}")]


@pytest.mark.parametrize(
    ("knob", "param", "code", "pointer"),
    [
        ({"type": "float", "default": 1, "max": 101}, "radius", "out-of-range", "max"),
        ({"type": "float", "default": 1, "min": -1}, "radius", "out-of-range", "min"),
        ({"type": "float", "default": 101}, "radius", "out-of-range", "default"),
        ({"type": "enum", "default": "full", "choices": ["full", "half"]}, "kernel", "bad-value", "choices/1"),
        ({"type": "float", "default": -1}, "reference", "bad-value", "default"),
        ({"type": "string", "default": "min"}, "reference", "bad-value", "default"),
    ],
)
def test_a_knob_stays_within_what_it_drives(knob, param, code, pointer):
    source = with_params(**{param: {"from": "knob"}}) | {"interface": {"knob": knob}}
    assert found(source) == [(code, f"/interface/knob/{pointer}")]


@pytest.mark.parametrize(
    ("kind", "default", "param", "fits"),
    [
        ("float", 1.0, "radius", True),
        ("int", 1, "radius", True),
        ("int", 1, "iterations", True),
        ("float", 1.0, "iterations", False),
        ("bool", True, "color", True),
        ("bool", True, "radius", False),
        ("string", "full", "kernel", False),
        ("int", 1, "reference", True),
        ("string", "max", "reference", True),
        ("color", [0, 0, 0], "radius", False),
    ],
)
def test_which_knob_drives_which_parameter(kind, default, param, fits):
    source = with_params(**{param: {"from": "knob"}}) | {"interface": {"knob": {"type": kind, "default": default}}}
    assert found(source) == ([] if fits else [("wrong-type", f"/nodes/field/params/{param}/from")])


def test_a_broken_knob_is_one_problem_however_often_it_is_used():
    source = nodes(
        field=FIELD | {"params": {"radius": {"from": "knob"}}}, drawing=LINES | {"params": {"sigma": {"from": "knob"}}}
    )
    source["interface"] = {"knob": {"type": "float", "default": "wide"}}
    assert found(source) == [("wrong-type", "/interface/knob/default")]


def test_problems_are_plain_data():
    assert json.loads(json.dumps(only(document(nane=1)).to_dict())) == {
        "code": "unknown-key",
        "pointer": "/nane",
        "found": '"nane"',
        "expected": "a key of the format",
        "hint": "did you mean 'name'?",
    }


def test_a_number_that_is_the_same_on_every_frame_takes_no_curve():
    steady = dataclasses.replace(CATALOGUE["flow"], params=(Param.int("seed", 1, animatable=False, help="Seed."),))
    source = with_params(seed={"curve": {"1": 1, "2": 5}})
    (problem,) = graph.check(source, CATALOGUE | {"flow": steady})
    assert (problem.code, problem.pointer) == ("wrong-type", "/nodes/field/params/seed/curve")
    assert problem.expected == "no curve: this number is the same on every frame; a whole number"
    assert not jsonschema.Draft202012Validator(graph.schema(CATALOGUE | {"flow": steady})).is_valid(source)
