import jsonschema
import pytest

from flowabs_nodes import graph
from flowabs_nodes.graph.reference_size import MEASURES, ReferenceSize
from tests.graph.fakes import CATALOGUE

EMPTY = {"format": "flowabs.graph/1", "nodes": {}}


@pytest.mark.parametrize(
    ("measure", "wide", "tall"),
    [("height", 4, 3), ("width", 3, 4), ("shorter", 3, 3), ("diagonal", 5, 5)],
)
def test_each_measure_of_a_window(measure, wide, tall):
    size = ReferenceSize(measure, 10)
    assert size.factor(30, 40) == wide
    assert size.factor(40, 30) == tall


@pytest.mark.parametrize("measure", MEASURES)
def test_a_document_may_say_any_measure(measure):
    source = EMPTY | {"reference_size": {measure: 540}}
    assert graph.load(source, CATALOGUE).reference_size == ReferenceSize(measure, 540)
    jsonschema.Draft202012Validator(graph.schema(CATALOGUE)).validate(source)


def test_the_older_spelling_is_a_height():
    assert graph.load(EMPTY | {"reference_height": 540}, CATALOGUE).reference_size == ReferenceSize("height", 540)
    assert graph.load(EMPTY, CATALOGUE).reference_size is None


def test_a_misspelt_measure_is_told_the_nearest():
    (problem,) = graph.check(EMPTY | {"reference_size": {"shortr": 540}}, CATALOGUE)
    assert "shorter" in problem.hint
    (problem,) = graph.check(EMPTY | {"reference_size": {}}, CATALOGUE)
    assert "height, width, shorter, diagonal" in problem.expected
