"""Figs. 4 and 11 to 13: with each iteration fewer and larger pieces of ink. The paper's values, tau = 0.2."""

from itertools import pairwise

import pytest

from flowabs_nodes.filters import etf, fdog, fdog_iterative, threshold
from tests.figures.graphs import PHOTOGRAPHS, code
from tools.gallery.measures import ink_components

TAU = 0.2


@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_coherence_grows_with_iterations_of_fdog(name):
    picture = code(name)
    flow = etf(picture)
    drawn = [ink_components(fdog_iterative(picture, flow, tau=TAU, iterations=i)[0]) for i in (1, 2, 3)]
    for before, after in pairwise(drawn):
        assert after.pieces < 0.85 * before.pieces
        assert after.mean_size > 1.25 * before.mean_size


@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_coherence_grows_with_iterations_of_the_flow(name):
    picture = code(name)
    flows = [etf(picture, iterations=i) for i in (1, 2, 3)]
    drawn = [ink_components(threshold(fdog(picture, flow), tau=TAU)) for flow in flows]
    for before, after in pairwise(drawn):
        assert after.pieces < before.pieces
        assert after.mean_size > before.mean_size
