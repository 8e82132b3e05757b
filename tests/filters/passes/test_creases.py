"""Creases as points, against the naive twin, and which of them stay."""

import numpy as np
import pytest

from flowabs_nodes.filters.passes.creases import alone, find_creases, unit_normals
from flowabs_nodes.filters.passes.edges import no_edges
from tests.filters.passes.scenes import roof
from tests.naive import creases as naive


@pytest.mark.parametrize(("theta", "h"), [(30.0, 1.0), (50.0, 1.7), (20.0, 0.5)])
def test_points_are_those_of_the_naive_twin(theta, h):
    normals, _ = roof(70, 26, 44)
    normals += np.random.default_rng(6).normal(0, 0.04, normals.shape).astype(np.float32)
    normals[3:6, 5:9], normals[20, 30] = 0, np.nan
    unit = unit_normals(normals)
    np.testing.assert_allclose(unit, naive.unit_normals(normals), atol=1e-6)
    edges, excess = find_creases(unit, theta, h)
    expected = naive.find_creases(unit.astype(np.float64), theta, h)
    found = np.stack([edges.x, edges.y, np.abs(edges.nx), np.abs(edges.ny), edges.strength, excess], axis=1)
    assert len(found) == len(expected) > 20
    np.testing.assert_allclose(found, expected, atol=0.02)
    np.testing.assert_array_equal(np.floor(edges.y).searchsorted(np.arange(27)), edges.rows)


def test_the_blunter_of_two_creases_side_by_side_goes():
    turns = np.zeros((12, 40))
    turns[:, 19:] += 70
    turns[:, 21:] += 35  # two pixels further
    turns[:, 31:] += 35  # and far away
    angle = np.radians(turns)
    unit = unit_normals(np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=2).astype(np.float32))
    creases, excess = find_creases(unit, 30.0, 0.5)
    kept = alone(creases, excess, no_edges(12))
    columns = {x: kept.strength[np.abs(kept.x - x) < 0.5].max() for x in (18.5, 20.5, 30.5)}
    assert columns[18.5] > 0.9
    assert columns[20.5] == 0
    assert columns[30.5] > 0.9


@pytest.mark.parametrize(("length", "low", "high"), [(1, 0.95, 1.0), (3, 0.1, 0.4), (5, 0.0, 0.0)])
def test_a_bend_is_no_crease_the_longer_the_less(length, low, high):
    turns = np.broadcast_to(np.interp(np.arange(40), [20, 20 + length], [0, 60]), (12, 40))
    angle = np.radians(turns)
    unit = unit_normals(np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=2).astype(np.float32))
    strength = find_creases(unit, 30.0, 1.0)[0].strength
    assert low <= strength.max(initial=0) <= high


@pytest.mark.parametrize("reach", [0.67, 1.0, 1.5])
def test_a_fold_that_runs_through_pixels_is_not_dashed(reach):
    y, x = np.mgrid[0:40, 0:40]
    turns = 50 * np.clip(x - 0.15 * y - 16.5, 0, 1)  # a pixel that it runs through has a mean of both normals
    angle = np.radians(turns)
    unit = unit_normals(np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=2).astype(np.float32))
    creases, _ = find_creases(unit, 30.0, reach)
    strongest = [creases.strength[creases.rows[row] : creases.rows[row + 1]].max(initial=0) for row in range(40)]
    assert np.mean(np.array(strongest) > 0.5) > 0.9
