"""Lines that are drawn anew every few frames."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import halo
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import boil as naive

AMOUNT = 2.5


def drawing():
    """Return soft lines of a photograph, and the flow that they follow."""
    code, flow = cases()["photo"]
    return filters.threshold(filters.fdog(code[..., 0], flow), softness=4.0), flow


def straight(width=1.5, shape=(200, 300)):
    """Return horizontal lines 20 px apart, and their flow."""
    y = np.indices(shape)[0] % 20
    flow = np.zeros((*shape, 2), np.float32)
    flow[..., 0] = 1
    return (1 - np.clip(width / 2 + 0.5 - np.abs(y - 10), 0, 1)).astype(np.float32), flow


@pytest.mark.parametrize(("size", "seed", "frame"), [(40.0, 1, 1), (7.3, 9, 2), (1.0, 0, -5), (3000.0, 2, 10**6)])
def test_equals_the_formula_in_float64(size, seed, frame):
    lines, flow = drawing()
    found = filters.boil(lines, flow, AMOUNT, 2, size, seed, frame, (7, -3))
    expected = naive.boil(lines, flow, AMOUNT, 2, size, seed, frame, (7, -3))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-5)
    assert np.abs(expected - lines).max() > 0.2


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    lines, flow = np.random.default_rng(1).random(shape, np.float32), random_flow(shape, 2)
    found = filters.boil(lines, flow, AMOUNT, size=5.0)
    np.testing.assert_allclose(found, naive.boil(lines, flow, AMOUNT, 2, 5.0, 1, 1), rtol=0, atol=1e-5)


def test_without_an_amount_nothing_changes():
    lines, flow = drawing()
    found = filters.boil(lines, flow, 0.0, frame=17)
    np.testing.assert_array_equal(found, lines)
    assert found is not lines


def test_a_drawing_is_held():
    lines, flow = drawing()
    frames = [filters.boil(lines, flow, AMOUNT, hold=3, frame=frame) for frame in range(-2, 8)]
    for first in (0, 3, 6):
        np.testing.assert_array_equal(frames[first], frames[first + 1])
        np.testing.assert_array_equal(frames[first], frames[first + 2])
    assert len({frame.tobytes() for frame in frames}) == 4
    assert not np.array_equal(filters.boil(lines, flow, AMOUNT, seed=2), filters.boil(lines, flow, AMOUNT))


def test_ink_moves_across_strokes_by_no_more_than_the_amount():
    lines, flow = straight()
    ink = 1 - filters.boil(lines, flow, AMOUNT, size=30.0)
    y = np.indices(lines.shape)[0] % 20 - 10
    assert ink[np.abs(y) > AMOUNT + 2.3].max() < 1e-6
    across = ((ink * y).reshape(10, 20, 300).sum(1) / ink.reshape(10, 20, 300).sum(1))[1:-1]
    assert 0.3 * AMOUNT < across.std() < 0.7 * AMOUNT
    assert abs(across.mean()) < 0.4 * AMOUNT
    fixed = filters.boil(np.tile(np.float32([1, 0.5, 1, 0]), (200, 75)), flow, AMOUNT)  # along the flow
    np.testing.assert_allclose(fixed, np.tile(np.float32([1, 0.5, 1, 0]), (200, 75)), rtol=0, atol=1e-5)


@pytest.mark.parametrize("width", [1.0, 1.5, 3.0])
def test_width_and_blackness_stay(width):
    lines, flow = straight(width)
    before, after = (1 - each.reshape(10, 20, 300)[1:-1] for each in (lines, filters.boil(lines, flow, 1.5)))
    np.testing.assert_allclose(after.sum(1).mean(), before.sum(1).mean(), rtol=0.02 if width > 1 else 0.1)
    assert after.sum(1).std() < 0.06 * width
    assert after.max(1).mean() > 0.8 * before.max()
    assert np.abs(after - before).mean() > 0.02


def test_strokes_are_not_torn_where_they_turn():
    size = 120
    lines, flow = np.ones((size, size), np.float32), np.zeros((size, size, 2), np.float32)
    lines[60, 60:], lines[60:, 60] = 0, 0  # a corner of a line along x and one along y
    flow[..., 0] = np.triu(np.ones((size, size)))
    flow[..., 1] = 1 - flow[..., 0]
    for frame in range(1, 40, 2):
        ink = 1 - filters.boil(lines, flow, 2.0, frame=frame)
        steps = np.minimum(ink.sum(0)[64:110], ink.sum(1)[64:110])
        assert steps.min() > 0.7
        assert ink[55:66, 55:66].sum() > 9  # 11 before


def test_the_sign_of_the_flow_does_not_count():
    lines, flow = drawing()
    signs = np.random.default_rng(0).choice([-1, 1], flow.shape[:2])[..., None].astype(np.float32)
    np.testing.assert_array_equal(filters.boil(lines, flow * signs, AMOUNT), filters.boil(lines, flow, AMOUNT))


@pytest.mark.parametrize("amount", [0.3, 1.0, 9.0])
def test_a_window_with_its_halo_has_the_same_bits(amount):
    lines, flow = drawing()
    far = halo.boil(amount)
    whole = filters.boil(lines, flow, amount, size=8.0)[20:40, 22:43]
    window = slice(20 - far, 40 + far), slice(22 - far, 43 + far)
    part = filters.boil(lines[window], flow[window], amount, size=8.0, origin=(22 - far, 20 - far))
    np.testing.assert_array_equal(part[far:-far, far:-far], whole)


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    lines, flow = straight()
    one, *others = each_thread_count(lambda: filters.boil(lines, flow, AMOUNT))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_errors_name_the_argument():
    lines, flow = drawing()
    for message, arguments in {
        "lines: expected finite pixels": {"lines": np.where(lines == 1, np.nan, lines)},
        "flow: expected the size of the picture": {"flow": flow[1:]},
        "amount: expected a number at least 0 and at most 100": {"amount": 101},
        "hold: expected a number at least 1": {"hold": 0},
        "size: expected a number at least 1": {"size": 0.5},
        "seed: expected a whole number": {"seed": 1.5},
        "frame: expected a whole number": {"frame": 1.5},
    }.items():
        with pytest.raises(ArgumentError, match=message):
            filters.boil(**{"lines": lines, "flow": flow, **arguments})
