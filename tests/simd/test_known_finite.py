import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.simd import finite
from flowabs_nodes.simd.known_finite import is_marked_finite, mark_finite, remember_finite


@pytest.fixture
def looks(monkeypatch):
    """Return a list that grows by one each time a kernel checks an array."""
    seen = []
    original = finite.over_pixels
    monkeypatch.setattr(finite, "over_pixels", lambda *args: seen.append(1) or original(*args))
    return seen


def test_an_array_is_looked_at_once_where_that_is_remembered(looks):
    array = np.ones((20, 30, 1), np.float32)
    with remember_finite():
        for _ in range(3):
            validate.plane("lines", array[..., 0])  # another view each time
        assert len(looks) == 1
        validate.plane("lines", array[:10, :, 0])
        assert len(looks) == 1, "a part of what is finite is finite"
        validate.plane("lines", array[..., 0].copy())
        assert len(looks) == 2
    validate.plane("lines", array[..., 0])
    assert len(looks) == 3, "outside, arrays may have been changed"


def test_a_part_does_not_vouch_for_the_whole(looks):
    array = np.ones((20, 30), np.float32)
    array[15, 3] = np.nan
    with remember_finite():
        validate.plane("code", array[:10])
        with pytest.raises(ArgumentError, match="found 1"):
            validate.plane("code", array)


def test_what_is_vouched_for_is_not_looked_at(looks):
    with remember_finite():
        array = mark_finite(np.ones((20, 30), np.float32))
        assert is_marked_finite(array)
        assert is_marked_finite(array[3:5])
        validate.plane("code", array)
    assert not looks
    assert not is_marked_finite(array)


def test_another_array_in_the_same_place_is_not_vouched_for():
    with remember_finite():
        known = {id(mark_finite(np.ones((20, 30), np.float32))) for _ in range(10)}
        assert not any(is_marked_finite(np.ones((20, 30), np.float32)) for _ in range(10)), known
