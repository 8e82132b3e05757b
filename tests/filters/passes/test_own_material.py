"""Materials agree with the ids of their pixels, where two passes take another of two objects."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.filters.passes.id_borders import id_borders
from flowabs_nodes.filters.passes.own_material import own_material
from tests.naive import aov_lines as naive


def pixels(height: int = 33, width: int = 71, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return ids of a few objects, and materials: stripes on them, mixed up at their borders."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((height, width))
    ids = np.uint32(1) + (np.hypot(x - 30, y - 16) < 11) + 2 * (x > 50).astype(np.uint32)
    materials = 10 * ids + (y // 9 % 2)
    other = np.roll(materials, 1, axis=1)
    return ids.astype(np.uint32), np.where(rng.random(ids.shape) < 0.3, other, materials).astype(np.uint32)


@pytest.mark.parametrize(("height", "width"), [(33, 71), (1, 1), (1, 40), (40, 1), (5, 16)])
def test_it_is_the_vote_of_the_pixels_around(height: int, width: int) -> None:
    ids, materials = pixels(height, width)
    np.testing.assert_array_equal(own_material(materials, ids, id_borders(ids)), naive.own_material(materials, ids))


def test_materials_within_one_object_stay() -> None:
    _, materials = pixels()
    ids = np.ones_like(materials)
    np.testing.assert_array_equal(own_material(materials, ids, id_borders(ids)), materials)


def test_an_object_that_is_seen_through_another_has_no_specks_at_its_border() -> None:
    """The border's pixels belong to one object by their ids, to the other by some of their materials."""
    y, x = np.indices((40, 60))
    inside = np.hypot(x - 30, y - 20) < 12
    ids = np.uint32(1) + inside
    materials = ids.astype(np.uint32)
    beside = inside & ~(np.roll(inside, 1, 0) & np.roll(inside, -1, 0) & np.roll(inside, 1, 1) & np.roll(inside, -1, 1))
    mixed = materials.copy()
    mixed[beside & (np.random.default_rng(2).random(ids.shape) < 0.1)] = 1
    depth = np.where(inside, 4, 9).astype(np.float32)
    clean, specked = (filters.aov_lines(depth, id=ids, material=each) for each in (materials, mixed))
    assert specked.material.max() == 0
    np.testing.assert_array_equal(specked.lines, clean.lines)
