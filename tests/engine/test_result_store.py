import numpy as np
import pytest

from flowabs_nodes.engine.result_store import ResultStore, StoredKey, image_bytes
from flowabs_nodes.image import Image
from tests.engine.fakes import picture

SIZE = 6 * 8 * 3 * 4


def key(name):
    return StoredKey(name, "image", 1)


@pytest.fixture
def store():
    return ResultStore(2 * SIZE)


def test_what_is_put_is_found_by_key_output_and_frame(store):
    image = picture()
    store.put(key("a"), image)
    assert store.get(key("a")) is image
    for other in (key("b"), StoredKey("a", "lines", 1), StoredKey("a", "image", 2)):
        assert store.get(other) is None
        assert other not in store


def test_what_was_used_longest_ago_goes_first(store):
    for name in "ab":
        store.put(key(name), picture())
    store.get(key("a"))
    store.put(key("c"), picture())
    assert [name for name in "abc" if key(name) in store] == ["a", "c"]
    assert store.bytes == store.peak_bytes == 2 * SIZE


def test_an_image_larger_than_the_bound_is_not_held_and_drops_nothing(store):
    store.put(key("a"), picture())
    store.put(key("large"), picture(height=60))
    assert key("a") in store
    assert key("large") not in store
    ResultStore(0).put(key("a"), picture())


def test_the_same_key_put_again_counts_once(store):
    for _ in range(3):
        store.put(key("a"), picture())
    assert (len(store), store.bytes) == (1, SIZE)


def test_keep_only(store):
    for name in "ab":
        store.put(key(name), picture())
    store.keep_only({key("b"), key("never put")})
    assert (len(store), store.bytes, key("b") in store) == (1, SIZE, True)
    store.keep_only(())
    assert (len(store), store.bytes, store.peak_bytes) == (0, 0, 2 * SIZE)


@pytest.mark.parametrize("alpha", [False, True])
def test_bytes_of_an_image_that_is_still_to_be_decoded(alpha):
    image = picture(alpha=alpha)
    later = image.with_codes(np.zeros((6, 8, 3), np.float32), "lab")
    assert image_bytes(later) == SIZE + (6 * 8 * 4 * 4 if alpha else 0)
    assert image_bytes(Image.from_array(np.zeros((5, 4)))) == 80
