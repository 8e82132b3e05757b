"""Fig. 5: what the separable kernel changes. The paper reports a mean colour distance of 0.00893 on its picture."""

import numpy as np
import pytest

from flowabs_nodes.filters import etf, flow_color
from flowabs_nodes.filters.flow.gradient import gradient
from tests.figures.graphs import PHOTOGRAPHS, code, photograph, run
from tools.gallery import drawings


def distance(picture, **options):
    """Colour distance at each pixel, components 0 to 1."""
    full, separable = (flow_color(etf(picture, kernel=kernel, **options)) for kernel in ("full", "separable"))
    return np.linalg.norm(full - separable, axis=2)


@pytest.mark.parametrize("name", PHOTOGRAPHS)
def test_on_photographs_it_is_about_a_tenth_and_most_where_there_is_no_edge(name):
    picture = code(name)
    apart, magnitude = distance(picture), gradient(picture).magnitude
    weak, strong = np.quantile(magnitude, [0.25, 0.97])
    assert 0.08 < apart.mean() < 0.12
    assert np.median(apart) < 0.04
    assert apart[magnitude >= strong].mean() < 0.5 * apart[magnitude <= weak].mean()
    assert distance(picture, pre_blur=8).mean() < 0.04


def test_on_a_clean_shape_it_is_below_the_papers():
    disc = drawings.disc_in_noise(sigma=0)
    assert distance(disc, pre_blur=1).mean() < 0.00893


def test_the_graph_of_the_figure_measures_the_same():
    drawn = run("fig05", photograph("chelsea.png"), "full", "separable")
    apart = np.linalg.norm(drawn["full"] - drawn["separable"], axis=2)
    assert apart.mean() == pytest.approx(distance(code("chelsea.png")).mean(), abs=0.005)
