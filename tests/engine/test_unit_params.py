import pytest

from flowabs_nodes.engine.plan import Unit
from flowabs_nodes.engine.unit_params import UnitParams, unit_offsets
from flowabs_nodes.errors import FlowabsError
from tests.engine.fakes import ADD, graph, node
from tests.engine.windows import MEAN, asking


def test_parameters_of_a_frame_are_computed_once_and_when_asked_for():
    asked = []
    a_graph = graph(node("a", ADD), node("b", ADD, {"image": "a"}))
    a_graph.values = lambda frame: asked.append(frame) or {"a": {"amount": frame}, "b": {"amount": -frame}}
    params = UnitParams(a_graph)
    assert asked == []
    assert [params[Unit(*each)]["amount"] for each in (("a", 3), ("b", 3), ("a", 4))] == [3, -3, 4]
    assert asked == [3, 4]


def test_what_is_wrong_with_a_parameter_names_the_frame():
    def values(frame):
        raise FlowabsError("no", node="a")

    a_graph = graph(node("a", ADD))
    a_graph.values = values
    with pytest.raises(FlowabsError) as failure:
        UnitParams(a_graph)[Unit("a", 7)]
    assert failure.value.frame == 7


def test_offsets_of_a_unit():
    a_graph = graph(node("a", ADD), node("mean", MEAN, {"image": "a"}, radius=1), node("bad", asking({"image": (1,)})))
    params = UnitParams(a_graph)
    assert unit_offsets(a_graph, Unit("a", 3), params) == {}
    assert unit_offsets(a_graph, Unit("mean", 3), params) == {"image": (-1, 0, 1)}
    with pytest.raises(FlowabsError) as failure:
        unit_offsets(a_graph, Unit("bad", 3), params)
    assert (failure.value.node, failure.value.frame, failure.value.code) == ("bad", 3, "wrong-frames")
