"""The matte of objects from the id that covers most of each pixel."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from tests.filters.flows import THIN
from tests.naive import id_matte as naive

LARGE = 2**32 - 1


def patches(shape=(23, 41), seed=0):
    """Return areas of five ids, some as large as ids get, and coverages, half of them 1."""
    random = np.random.default_rng(seed)
    known = np.array([0, 1, 2, LARGE - 1, LARGE], np.uint32)
    small = random.choice(known, [-(-side // 3) for side in shape])
    ids = np.kron(small, np.ones((3, 3), np.uint32))[: shape[0], : shape[1]].astype(np.uint32)
    return ids, np.minimum(random.uniform(0.3, 1.7, shape), 1).astype(np.float32)


def disc(size=64, samples=8):
    """Return ids and coverage of a disc, 7, on a ground that is half 0 and half 9, and the coverage of each id."""
    y, x = (np.indices((size * samples, size * samples)) + 0.5) / samples
    fine = np.where(np.hypot(x - 31.3, y - 30.8) < 20, 7, np.where(x + 0.3 * y < 40, 0, 9))
    blocks = fine.reshape(size, samples, size, samples)
    shares = {number: (blocks == number).mean(axis=(1, 3)) for number in (0, 7, 9)}
    most = np.array(list(shares))[np.argmax(list(shares.values()), axis=0)]
    return most.astype(np.uint32), np.max(list(shares.values()), axis=0), shares


@pytest.mark.parametrize("shape", [(23, 41), *THIN])
@pytest.mark.parametrize("chosen", [[2], [0, LARGE], [1, 2, LARGE - 1, 5]])
def test_equals_the_definition(shape, chosen):
    ids, coverage = patches(shape)
    found = filters.id_matte(ids, chosen, coverage)
    np.testing.assert_allclose(found, naive.id_matte(ids, set(chosen), coverage), rtol=0, atol=1e-6)


def test_the_mattes_of_all_objects_add_up_to_1():
    ids, coverage = patches()
    each = sum(filters.id_matte(ids, [number], coverage).astype(np.float64) for number in np.unique(ids))
    np.testing.assert_allclose(each, 1, rtol=0, atol=1e-6)
    objects = filters.id_matte(ids, None, coverage)
    np.testing.assert_allclose(objects, 1 - filters.id_matte(ids, [0], coverage), rtol=0, atol=1e-6)


def test_it_is_the_coverage_that_a_renderer_would_have_written():
    ids, coverage, shares = disc()
    for number, share in shares.items():
        off = np.abs(filters.id_matte(ids, [number], coverage) - share)
        edge = (share > 0) & (share < 1)
        assert off[edge].mean() < 0.01
        assert np.abs(np.where(ids == number, coverage, 0) - share)[edge].mean() > 0.05  # what coverage alone gives
        assert off.max() < 0.1  # where three meet


def test_without_coverage_it_is_hard():
    ids, _ = patches()
    np.testing.assert_array_equal(filters.id_matte(ids, [2, LARGE]), np.isin(ids, [2, LARGE]))
    np.testing.assert_array_equal(filters.id_matte(ids, None), ids != 0)
    assert filters.id_matte(ids, []).max() == 0


def test_many_ids_are_found_whatever_their_order():
    random = np.random.default_rng(3)
    ids = random.integers(0, 2**32, (40, 50), np.uint32)
    chosen = random.permutation(ids.reshape(-1)[::3]).tolist()
    np.testing.assert_array_equal(filters.id_matte(ids, chosen + chosen[:5]), np.isin(ids, chosen))


def test_a_picture_turned_over_has_its_matte_turned_over():
    ids, coverage = patches()
    matte = filters.id_matte(ids, [1, 2], coverage)
    np.testing.assert_array_equal(filters.id_matte(ids[::-1, ::-1], [1, 2], coverage[::-1, ::-1])[::-1, ::-1], matte)
    np.testing.assert_array_equal(filters.id_matte(ids.T, [1, 2], coverage.T).T, matte)


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    ids, coverage = patches((150, 37))
    one, *others = each_thread_count(lambda: filters.id_matte(ids, [1, LARGE], coverage))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_errors_name_the_argument():
    ids, coverage = patches()
    for message, arguments in {
        r"ids: expected whole numbers, found dtype float32": (coverage, None),
        r"ids: expected shape \(H, W\)": (ids[..., None], None),
        r"ids: expected ids from 0 to 4294967295, found -1 to 3": (np.array([[-1, 3]]), None),
        r"chosen: expected ids from 0 to 4294967295, found 4294967296": (ids, [1, 2**32]),
        r"chosen: expected ids from 0 to 4294967295, found -2": (ids, [1, -2]),
        r"coverage: expected the size of the picture, 41x23, found 41x22": (ids, None, coverage[1:]),
        r"coverage: expected finite pixels": (ids, None, np.where(ids == 2, np.nan, coverage)),
    }.items():
        with pytest.raises(ArgumentError, match=message):
            filters.id_matte(*arguments)
