import numpy as np
import pytest

from flowabs_nodes.filters import etf
from flowabs_nodes.filters.flow import etf_passes
from flowabs_nodes.filters.flow.footprint_sums import footprint_passes
from tests.filters.pictures import noise


def horizontal(shape=(7, 20), **others):
    """A horizontal field of tangents, but for the pixel in the middle; |g| is 1 everywhere, but for that pixel."""
    tangent, magnitude = np.zeros((*shape, 2), np.float32), np.ones(shape, np.float32)
    tangent[..., 0] = 1
    tangent[3, 10] = others.get("middle", (1, 0))
    magnitude[3, 10] = others.get("strength", 1)
    return tangent, magnitude


def smooth(tangent, magnitude, reference, iterations=1, radius=1.5, kernel="full"):
    passes = footprint_passes(kernel, [radius], *magnitude.shape)
    return etf_passes.smooth(tangent, magnitude, reference, iterations, passes)


def direction(x, y):
    return np.array([x, y]) / np.hypot(x, y)


DIAGONAL = direction(1, 1)


@pytest.mark.parametrize("kernel", ["full", "separable"])
def test_a_field_of_one_direction_stays(kernel):
    tangent, magnitude = horizontal()
    np.testing.assert_allclose(smooth(tangent.copy(), magnitude, 1.0, 3, 4.0, kernel), tangent, atol=1e-7)


def test_a_diagonal_tangent_is_turned_by_its_eight_neighbours():
    """M t = 8 (t.x, 0) + t, all ĝ equal: t.x counts nine times, t.y once."""
    flow = smooth(*horizontal(middle=DIAGONAL), reference=1.0)
    np.testing.assert_allclose(flow[3, 10], direction(9, 1), atol=1e-6)


def test_neighbours_that_are_stronger_by_all_count_twice():
    """w_m is 1 for ĝ(y) = 1 and ĝ(x) = 0, and one half for the pixel itself."""
    flow = smooth(*horizontal(middle=DIAGONAL, strength=0), reference=1.0)
    np.testing.assert_allclose(flow[3, 10], direction(17, 1), atol=1e-6)


def test_neighbours_that_are_weaker_by_all_count_nothing():
    tangent, magnitude = horizontal(middle=DIAGONAL)
    magnitude[:], magnitude[3, 10] = 0, 1
    np.testing.assert_allclose(smooth(tangent, magnitude, 1.0)[3, 10], DIAGONAL, atol=1e-6)


def test_a_reference_of_0_makes_all_strengths_equal():
    flow = smooth(*horizontal(middle=DIAGONAL, strength=0), reference=0)
    np.testing.assert_allclose(flow[3, 10], direction(9, 1), atol=1e-6)


def test_tangents_at_right_angles_do_not_count():
    flow = smooth(*horizontal(middle=(0, 1)), reference=1.0)
    np.testing.assert_allclose(flow[3, 10], [0, 1], atol=1e-7)


def test_opposite_tangents_are_one_direction():
    tangent, magnitude = horizontal(middle=DIAGONAL)
    opposite = tangent * np.random.default_rng(0).choice([-1, 1], magnitude.shape)[..., None].astype(np.float32)
    opposite[3, 10] = tangent[3, 10]
    np.testing.assert_array_equal(smooth(opposite, magnitude, 1.0)[3, 10], smooth(tangent, magnitude, 1.0)[3, 10])


def test_a_zero_tangent_stays_zero():
    assert not smooth(*horizontal(middle=(0, 0)), reference=1.0)[3, 10].any()


@pytest.mark.parametrize("options", [{}, {"kernel": "separable"}, {"adaptive": True}, {"fill": None}])
@pytest.mark.parametrize(("columns", "halo"), [(16, 64), (48, 64), (512, 0), (32, 12)])
def test_tiles_and_what_is_done_in_one_go_change_no_bit(monkeypatch, columns, halo, options):
    code = noise(70, 101)
    code[30:50, 40:70] = 100  # with tangents missing
    whole = etf(code, 6.0, 4, **options)
    monkeypatch.setattr(etf_passes, "TILE_COLUMNS", columns)
    monkeypatch.setattr(etf_passes, "TILE_TO_HALO", 0)
    monkeypatch.setattr(etf_passes, "HALO", halo)
    np.testing.assert_array_equal(etf(code, 6.0, 4, **options), whole)
