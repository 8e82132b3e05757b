import math

import pytest

from flowabs_nodes.choices import Choices
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.nodes.declare import MASK, MIX, Node, Param, Port

COLOR = Port("image", "color", "In.")


OUT = Port("image", "color", "Out.")


def node(inputs=(COLOR,), outputs=(OUT,), params=(), **more):
    return Node("thing", 1, "Help.", inputs, outputs, params, lambda context: None, **more)


# ---------------------------------------------------------------------- ports


@pytest.mark.parametrize(
    ("types", "takes"),
    [
        ("color", {"color": "color", "mono": "color", "matte": "color"}),
        ("mono", {"mono": "mono", "matte": "mono"}),
        ("matte", {"matte": "matte"}),
        ("flow", {"flow": "flow"}),
        ("data", {"data": "data"}),
        ("color|mono|matte", {"color": "color", "mono": "mono", "matte": "matte"}),
        ("color|mono", {"color": "color", "mono": "mono", "matte": "color"}),
        ("any", {kind: kind for kind in ("color", "mono", "matte", "flow", "data")}),
    ],
)
def test_what_may_go_where(types, takes):
    port = Port("p", types, "Help.")
    found = {kind: port.takes(kind) for kind in ("color", "mono", "matte", "flow", "data")}
    assert {kind: inside for kind, inside in found.items() if inside} == takes


def test_an_output_may_be_of_the_type_of_an_input():
    assert Port("image", "=image", "Out.").same_as == "image"
    assert Port("image", "color", "Out.").same_as is None


# ---------------------------------------------------------------------- nodes


@pytest.mark.parametrize(
    ("inputs", "outputs", "mixes"),
    [
        ((COLOR,), (Port("image", "color", ""),), True),
        ((Port("image", "color|mono", ""),), (Port("image", "=image", ""),), True),
        ((COLOR,), (Port("image", "color", ""), Port("ink", "color", "")), True),
        ((COLOR,), (Port("flow", "flow", ""),), False),
        ((COLOR,), (Port("lines", "matte", ""),), False),
        ((COLOR,), (), False),
        ((), (Port("image", "color", ""),), False),
        ((Port("flow", "flow", ""),), (Port("image", "color", ""),), False),
    ],
)
def test_who_has_mask_and_mix(inputs, outputs, mixes):
    declared = node(inputs, outputs)
    assert declared.mixes is mixes
    assert (declared.all_inputs.get("mask") is MASK) is mixes
    assert (declared.all_params.get("mix") is MIX) is mixes


def test_names():
    assert node().name == "thing@1"
    for type in ("Thing", "1thing", "a-b", "", "a@1"):
        with pytest.raises(ArgumentError):
            Node(type, 1, "", (), (), (), lambda context: None)
    with pytest.raises(ArgumentError):
        node(params=(Param.float("image", 1.0, help=""),))


def test_defaults_leave_out_what_is_required():
    declared = node(params=(Param.file("file", role="input", help=""), Param.float("a", 2.0, help="")))
    assert declared.defaults() == {"a": 2.0, "mix": 1.0}
    assert declared.file_param is declared.params[0]


def test_labels_are_made_of_names_unless_they_are_given():
    declared = node(params=(Param.float("pre_blur", 1.0, help=""), Param.bool("b", True, label="Both", help="")))
    assert (declared.label, declared.category) == ("Thing", "utility")
    assert [param.label for param in declared.params] == ["Pre blur", "Both"]
    assert node(label="A thing", category="weather").label == "A thing"


MODE = Param.enum("mode", "a", ("a", "b"), help="")
FLAG = Param.bool("flag", False, help="")


def conditional(name="x", **enabled_when):
    return Param.float(name, 1.0, enabled_when=enabled_when, help="")


def test_a_parameter_is_enabled_beside_all_values_that_it_names():
    declared = node(params=(MODE, FLAG, conditional(mode=("b",), flag=(True,))))
    assert not declared.is_enabled("x", {})
    assert not declared.is_enabled("x", {"mode": "b"})
    assert not declared.is_enabled("x", {"mode": "a", "flag": True})
    assert declared.is_enabled("x", {"mode": "b", "flag": True})
    assert declared.is_enabled("mode", {})
    assert declared.is_enabled("mix", {})


@pytest.mark.parametrize(
    ("params", "message"),
    [
        ((MODE, conditional(mood=("b",))), "mode"),  # the nearest name
        ((MODE, conditional(x=("b",))), "enum or a bool"),
        ((MODE, conditional("y"), conditional(y=(1.0,))), "enum or a bool"),
        ((MODE, conditional(mode=("c",))), "'a', 'b'"),
        ((MODE, conditional(mode=())), "values of 'mode'"),
        ((FLAG, conditional(flag=("yes",))), "true or false"),
        ((MODE, Param.bool("flag", True, enabled_when={"mode": ("b",)}, help=""), conditional(flag=(True,))), "always"),
        ((MODE, Param("x", "float", None, "", required=True, enabled_when={"mode": ("b",)})), "default"),
    ],
)
def test_a_wrong_condition_is_refused(params, message):
    with pytest.raises(ArgumentError, match="enabled_when of 'x'") as caught:
        node(params=params)
    assert message in str(caught.value)


def test_sections_are_in_order_of_their_first_parameter():
    params = [
        Param.float(name, 1.0, group=group, help="") for name, group in (("a", "B"), ("c", ""), ("d", "B"), ("e", "A"))
    ]
    found = node(params=tuple(params)).sections()
    assert {group: [param.name for param in each] for group, each in found.items()} == {
        "B": ["a", "d"],
        "": ["c", "mix"],
        "A": ["e"],
    }
    assert list(found) == ["B", "", "A"]


def test_numbers_take_curves_unless_they_say_no():
    assert FLOAT.animatable
    assert INT.animatable
    assert not any(param.animatable for param in (BOOL, ENUM, TEXT, COLOR_PARAM, OWN))
    assert not Param.int("seed", 1, animatable=False, help="").animatable


def test_choices_have_labels_and_meanings():
    words = Choices({"one": "just one", "two": "a pair"}, {"two": "A pair"})
    param = Param.enum("e", "one", words, help="")
    assert param.choice_labels == {"one": "One", "two": "A pair"}
    assert param.choice_meanings == {"one": "just one", "two": "a pair"}
    assert (ENUM.choice_labels, ENUM.choice_meanings) == ({"one": "One", "two": "Two"}, {})


def test_extra_inputs_have_any_name():
    layers = Port("layer", "any", "A layer.")
    assert node(extra_inputs=layers).input("whatever") is layers
    assert node().input("whatever") is None


# ---------------------------------------------------------------------- parameters

FLOAT = Param.float("f", 1.0, min=0, max=10, unit="px", help="")
ABOVE = Param("a", "float", 1.0, "", min=0, above=True)
INT = Param.int("i", 1, min=0, max=10, help="")
BOOL = Param.bool("b", True, help="")
ENUM = Param.enum("e", "one", ("one", "two"), help="")
TEXT = Param.string("s", "", help="")
COLOR_PARAM = Param.color("c", (0.0, 0.0, 0.0), help="")
NULL = Param.float("n", None, nullable=True, help="")
OWN = Param.custom("o", 1, schema={}, parse=lambda value: None if value == 1 else "one", help="")


@pytest.mark.parametrize(
    ("param", "value", "result"),
    [
        (FLOAT, 0, 0.0),
        (FLOAT, 10, 10.0),
        (FLOAT, 2.5, 2.5),
        (ABOVE, 1e-9, 1e-9),
        (INT, 3, 3),
        (BOOL, False, False),
        (ENUM, "two", "two"),
        (TEXT, "x", "x"),
        (COLOR_PARAM, [1, 2, 3], (1.0, 2.0, 3.0)),
        (NULL, None, None),
        (NULL, -5, -5.0),
        (OWN, 1, 1),
    ],
)
def test_good_values(param, value, result):
    assert param.problem(value) is None
    checked = param.check(value)
    assert checked == result
    assert type(checked) is type(result)


@pytest.mark.parametrize(
    ("param", "value", "code"),
    [
        (FLOAT, -1, "out-of-range"),
        (FLOAT, 11, "out-of-range"),
        (FLOAT, math.nan, "bad-value"),
        (FLOAT, math.inf, "bad-value"),
        (FLOAT, True, "wrong-type"),
        (FLOAT, "1", "wrong-type"),
        (FLOAT, None, "wrong-type"),
        (FLOAT, 10**400, "bad-value"),
        (ABOVE, 0, "out-of-range"),
        (INT, 1.0, "wrong-type"),
        (INT, True, "wrong-type"),
        (INT, 11, "out-of-range"),
        (BOOL, 1, "wrong-type"),
        (ENUM, "three", "bad-value"),
        (ENUM, 1, "wrong-type"),
        (TEXT, 1, "wrong-type"),
        (COLOR_PARAM, [1, 2], "wrong-type"),
        (COLOR_PARAM, [1, 2, math.nan], "bad-value"),
        (COLOR_PARAM, "red", "wrong-type"),
        (OWN, 2, "bad-value"),
    ],
)
def test_bad_values(param, value, code):
    found = param.problem(value)
    assert found is not None
    assert found[0] == code
    with pytest.raises(ArgumentError) as caught:
        param.check(value)
    assert caught.value.code == code
    assert caught.value.parameter == param.name


def test_the_rule_in_words():
    assert FLOAT.expected == "a number from 0 to 10 (px)"
    assert ABOVE.expected == "a number above 0"
    assert NULL.expected == "a number, or null"
    assert ENUM.expected == "one of 'one', 'two'"


def test_units_say_how_a_value_scales():
    assert FLOAT.scales == 1
    assert Param.float("x", 1.0, unit="code values/px", help="").scales == -1
    assert Param.float("x", 1.0, unit="code values", help="").scales == 0
