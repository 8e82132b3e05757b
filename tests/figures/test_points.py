"""Fig. 8: lines from isolated points. Radius 10, 5 iterations, pre_blur 4; sigma_m 6, sigma_c 2."""

import numpy as np
import pytest

from tests.figures.graphs import run
from tools.gallery import drawings
from tools.gallery.measures import f_score, ink_components, is_closed_ring

CENTRE = (drawings.CENTRE, drawings.CENTRE)


def test_dots_on_a_circle_become_one_closed_ring():
    drawn = run("fig08", drawings.dots_on_circle(), "dog", "fdog")
    assert ink_components(drawn["dog"]).pieces == 28
    assert ink_components(drawn["fdog"]).pieces == 1
    assert is_closed_ring(drawn["fdog"], CENTRE, drawings.RING, 3)
    assert not is_closed_ring(drawn["dog"], CENTRE, drawings.RING, 3)


@pytest.mark.parametrize(
    ("drawing", "dots", "pieces"), [(drawings.dots_x(), 29, 5), (drawings.dots_t(), 19, 2)], ids=["x", "t"]
)
def test_junctions_come_apart_in_one_pass(drawing, dots, pieces):
    drawn = run("fig08", drawing, "dog", "fdog")
    assert ink_components(drawn["dog"]).pieces == dots
    assert ink_components(drawn["fdog"]).pieces <= pieces


@pytest.mark.parametrize(
    "drawing", [drawings.dots_on_circle(), drawings.dots_x(), drawings.dots_t()], ids=["circle", "x", "t"]
)
def test_further_passes_with_a_little_blur_join_them_all(drawing):
    lines = run("fig08", drawing, "third")["third"]
    assert ink_components(lines).pieces == 1
    assert f_score(lines, drawing < 128, 10).f_score == 1  # all of it at the dots, and none left out


def test_a_ring_with_a_gap_or_a_stroke_too_far_is_not_one():
    y, x = np.mgrid[:200, :200]
    off = np.abs(np.hypot(x - CENTRE[0], y - CENTRE[1]) - drawings.RING)
    ring = np.where(off < 1, 0.0, 1.0)
    assert is_closed_ring(ring, CENTRE, drawings.RING)
    assert not is_closed_ring(np.where(y == 100, 1.0, ring), CENTRE, drawings.RING)
    assert not is_closed_ring(np.where((y == 100) & (x < 45), 0.0, ring), CENTRE, drawings.RING)
    assert not is_closed_ring(np.ones((200, 200)), CENTRE, drawings.RING)
