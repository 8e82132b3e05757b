import pytest

from flowabs_nodes.errors import FlowabsError, closest, nearest


@pytest.mark.parametrize(
    ("name", "known", "right"),
    [
        ("sigma_C", ["sigma_m", "sigma_c", "sigma_s"], "sigma_c"),
        ("SIGMA_M", ["sigma_c", "sigma_m"], "sigma_m"),
        ("ETF@1", ["etf@1", "lic@1"], "etf@1"),
        ("fig1", ["fig01", "fig10", "fig21"], "fig01"),
        ("Fig007", ["fig06", "fig07", "fig17"], "fig07"),
        ("shot10", ["shot0010", "shot0100"], "shot0010"),
        ("srgb", ["sRGB", "lin_rec709"], "sRGB"),
        ("brigth", ["bright", "plate"], "bright"),
        ("line-width", ["line_amount", "line_width"], "line_width"),
        ("Line Width", ["linewidths", "line_width"], "line_width"),
        ("ARRI_LogC3", ["ARRI LogC4", "arri_logc4", "arri_logc3_ei800"], "arri_logc3_ei800"),
        ("abstr", ["astra", "abstraction"], "abstraction"),
        ("zzz", ["bright"], None),
    ],
)
def test_the_nearest_name_is_found_case_and_zeros_aside(name, known, right):
    assert closest(name, known) == right
    assert nearest(name, known) == (f"did you mean {right!r}?" if right else "known: bright")


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ("radius: expected a number", "node n: radius: expected a number"),
        ("radius['x']: expected a number", "node n: radius['x']: expected a number"),
        ("radius_2: expected a number", "node n: parameter radius: radius_2: expected a number"),
        ("5 is too much", "node n: parameter radius: 5 is too much"),
        ("radius 'x' is not in the file", "node n: radius 'x' is not in the file"),
        ("node 'n' has none", "parameter radius: node 'n' has none"),
        ("node 'n2' has none", "node n: parameter radius: node 'n2' has none"),
    ],
)
def test_node_and_parameter_are_named_once(message, text):
    assert str(FlowabsError(message, node="n", parameter="radius")) == text


def test_a_message_may_begin_with_any_word_where_no_place_is_known():
    assert str(FlowabsError("None is no number")) == "None is no number"
