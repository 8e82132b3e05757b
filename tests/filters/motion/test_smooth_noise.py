"""A field of vectors by chance."""

import numpy as np
import pytest

from flowabs_nodes.filters.motion.smooth_noise import smooth_noise
from tests.naive.boil import vectors


def test_the_very_numbers():
    """They are the same on any machine: sums, products and roots alone."""
    field = smooth_noise((40, 50), (0, 0), 16.0, 1, 7)
    assert field.vectors.shape == (2, field.rows[-1] + 2, field.columns[-1] + 2)
    known = [
        [0.5381904244422913, 0.6669260859489441, 0.5095930099487305],
        [0.8428232669830322, -0.7451238632202148, 0.8604155778884888],
    ]
    np.testing.assert_array_equal(field.vectors[:, 0, :3], np.float32(known))


def test_vectors_point_everywhere_and_are_no_longer_than_1():
    found = vectors((400, 400), (0, 0), 4.0, 3, 0).reshape(-1, 2)
    assert np.linalg.norm(found, axis=1).max() <= 1 + 1e-6
    assert np.abs(found.mean(0)).max() < 0.02
    np.testing.assert_allclose(np.cov(found.T) / found.var(), np.eye(2), atol=0.06)
    lattice = smooth_noise((400, 400), (0, 0), 4.0, 3, 0).vectors.reshape(2, -1)
    np.testing.assert_allclose(np.hypot(*lattice), 1, atol=1e-6)
    counts = np.histogram(np.arctan2(*lattice), bins=16)[0]
    assert counts.min() > 0.8 * counts.mean()


def test_it_is_smooth_over_its_size():
    found = vectors((100, 100), (0, 0), 25.0, 1, 0)
    for axis in (0, 1):
        steps = np.diff(found, axis=axis)
        assert np.abs(steps).max() < 2 * 1.875 / 25
        assert np.abs(np.diff(steps, axis=axis)).max() < 2 * 6 / 25**2


def test_fields_of_other_numbers_and_seeds_have_nothing_in_common():
    fields = [vectors((200, 200), (0, 0), 5.0, seed, number) for seed, number in ((1, 0), (1, 1), (2, 0), (0, 1))]
    for i, one in enumerate(fields):
        for other in fields[:i]:
            assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.05


@pytest.mark.parametrize("origin", [(13, 5), (-40, -7)])
def test_it_belongs_to_places(origin):
    whole = vectors((100, 100), (-50, -20), 11.0, 1, 4)
    part = vectors((20, 30), origin, 11.0, 1, 4)
    np.testing.assert_array_equal(part, whole[origin[1] + 20 :, origin[0] + 50 :][:20, :30])
