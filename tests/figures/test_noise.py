"""Fig. 9: a disc under Gaussian noise of 40 code values."""

import numpy as np
import pytest

from flowabs_nodes.filters import dog, etf, fdog, threshold
from tests.figures.graphs import run
from tools.gallery import drawings
from tools.gallery.measures import f_score

CONTOUR = drawings.disc_contour()
SEEDS = range(6)


def test_fdog_finds_the_contour():
    """At the paper's low threshold, tau = 0.2."""
    scores = []
    for seed in SEEDS:
        code = drawings.disc_in_noise(seed)
        flow = etf(code, radius=8, iterations=3, pre_blur=6)
        lines = threshold(fdog(code, flow, sigma_m=16, sigma_c=0.9, rho=0.97), tau=0.2)
        scores.append(f_score(lines, CONTOUR).f_score)
    assert np.mean(scores) > 0.96
    assert min(scores) > 0.93


def test_isotropic_dog_does_not_at_any_width_and_threshold():
    codes = [drawings.disc_in_noise(seed) for seed in SEEDS[:2]]
    best = 0.0
    for sigma_c in (1.0, 1.5, 1.75, 2.0, 2.5, 3.0):
        responses = [dog(code, sigma_c, 1.0) for code in codes]
        for contrast in (1, 2, 4, 6, 8, 10, 12, 15):
            scores = [f_score(threshold(response, contrast=contrast), CONTOUR).f_score for response in responses]
            best = max(best, float(np.mean(scores)))
    assert 0.45 < best < 0.6


def test_the_graph_of_the_figure_does_so():
    drawn = run("fig09", drawings.disc_in_noise(), "dog_best", "fdog")
    assert f_score(drawn["fdog"], CONTOUR).f_score > 0.85
    assert f_score(drawn["dog_best"], CONTOUR).f_score < 0.6


def test_f_score():
    assert f_score(np.where(CONTOUR, 0, 1), CONTOUR) == (1, 1, 1)
    assert f_score(np.ones_like(CONTOUR), CONTOUR) == (0, 0, 0)
    everywhere = f_score(np.zeros_like(CONTOUR), CONTOUR)
    assert everywhere.recall == 1
    assert everywhere.precision < 0.1
    half = f_score(np.where(CONTOUR & (np.arange(200) < 100), 0, 1), CONTOUR)
    assert half.precision == 1
    assert half.recall == pytest.approx(0.5, abs=0.02)
