import sys

import cv2
import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters import blur, optical_flow
from tests.filters.flows import THIN

WORLD = blur(np.random.default_rng(1).uniform(-200, 450, (120, 140)).astype(np.float32), 2.0)


def view(dx=0, dy=0):
    """Return the world as it is seen when everything has moved right by dx and down by dy."""
    return WORLD[20 - dy : 100 - dy, 20 - dx : 120 - dx]


def test_finds_where_pixels_come_from_and_go_to():
    motion = optical_flow(view(), before=view(-3, 2), after=view(6, -4))
    assert motion.shape == (80, 100, 4)
    # Before, everything was 3 to the left and 2 further down; after, it is 6 to the right and 4 further up. y is up.
    expected = [-3, -2, -6, -4]
    np.testing.assert_allclose(np.median(motion[10:-10, 10:-10], axis=(0, 1)), expected, atol=0.05)
    assert np.abs(motion[15:-15, 15:-15] - expected).mean() < 0.1


def test_towards_a_frame_that_is_not_there_it_is_0():
    first, last = optical_flow(view(), after=view(6, -4)), optical_flow(view(), before=view(-3, 2))
    assert not first[..., :2].any()
    assert not last[..., 2:].any()
    assert not optical_flow(view()).any()


def test_what_moves_about_evenly_is_taken_to_move_evenly():
    def ways(dx, dy):
        """Return the motion, and that of each way alone, where everything goes on by (dx, dy)."""
        before, after = view(-3, 2), view(dx, dy)
        alone = optical_flow(view(), before) + optical_flow(view(), after=after)
        return optical_flow(view(), before, after), alone

    motion, alone = ways(3, -2)
    assert np.abs(motion[..., :2] - motion[..., 2:]).mean() < 0.2 * np.abs(alone[..., :2] - alone[..., 2:]).mean()
    motion, alone = ways(7, -5)  # so far apart is no mistake
    assert np.abs(motion - alone)[20:-20, 20:-20].max() < 1e-3


@pytest.mark.parametrize("preset", ["ultrafast", "fast", "medium"])
def test_the_same_bits_on_any_number_of_threads(preset):
    noise = [np.random.default_rng(k).uniform(0, 255, (90, 130)) for k in range(3)]
    before, found = cv2.getNumThreads(), []
    try:
        for threads in (1, 2, 3, 7):
            cv2.setNumThreads(threads)
            found.append(optical_flow(noise[0], noise[1], noise[2], preset))
    finally:
        cv2.setNumThreads(before)
    assert found[0].any()
    assert all(np.array_equal(found[0], each) for each in found)


def test_presets_and_blur_do_something():
    noise = np.random.default_rng(1).normal(0, 20, (80, 100)).astype(np.float32)
    frames = view(), view(-3, 2) + noise
    found = [optical_flow(*frames, preset=each) for each in ("ultrafast", "fast", "medium")]
    found.append(optical_flow(*frames, pre_blur=3))
    assert all(not np.array_equal(a, b) for i, a in enumerate(found) for b in found[:i])


def test_beyond_8_bits_it_is_clipped():
    bright = np.clip(view() + 120, None, 255), np.clip(view(-3, 2) + 120, None, 255)
    beyond = view() + 120, view(-3, 2) + 120
    assert np.array_equal(optical_flow(*bright, pre_blur=0), optical_flow(*beyond, pre_blur=0))


@pytest.mark.parametrize("shape", [*THIN, (11, 13)])
def test_small_pictures(shape):
    code = np.random.default_rng(1).uniform(0, 255, shape)
    motion = optical_flow(code, code[::-1], code)
    assert motion.shape == (*shape, 4)
    assert np.isfinite(motion).all()


def test_errors():
    code = np.zeros((20, 30))
    with pytest.raises(ArgumentError, match="after: expected the size of the picture, 30x20, found 29x20"):
        optical_flow(code, after=code[:, :29])
    with pytest.raises(ArgumentError, match="before: expected finite"):
        optical_flow(code, np.full((20, 30), np.nan))
    with pytest.raises(ArgumentError, match="preset: expected one of 'ultrafast'"):
        optical_flow(code, preset="slow")
    with pytest.raises(ArgumentError, match="pre_blur"):
        optical_flow(code, pre_blur=-1)


def test_without_opencv_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(FlowabsError, match="optical_flow needs OpenCV, which is not installed") as failure:
        optical_flow(np.zeros((20, 30)))
    assert "flowabs-nodes[motion]" in failure.value.hint
