import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.filters.flow.fill import flow_fill
from flowabs_nodes.filters.flow.gradient import gradient
from tests.filters.pictures import photo
from tests.naive import fill as naive
from tests.naive.etf import degrees_between


def with_holes(height, width, share=0.7):
    """A picture of few gradients: flat but for some pixels."""
    rng = np.random.default_rng(3)
    return np.where(rng.random((height, width)) < share, 100, rng.uniform(0, 255, (height, width))).astype(np.float32)


@pytest.mark.parametrize("fill", [0.0, 2.0, 40.0])
@pytest.mark.parametrize(
    "code",
    [photo()[:33, :18], with_holes(16, 16, 0.97), with_holes(21, 37, 0.97), with_holes(1, 9), with_holes(6, 1)],
    ids=["photo", "square", "odd", "row", "column"],
)
def test_equals_the_direct_reading(code, fill):
    tangent, magnitude = gradient(code)
    filled = flow_fill(tangent, magnitude, fill)
    expected = naive.flow_fill(np.float64(tangent), np.float64(magnitude), fill)
    assert np.median(degrees_between(filled, expected)) < 1e-4
    assert np.quantile(degrees_between(filled, expected), 0.99) < 1e-2


FLIPS = {  # of a picture, and of the tangents in it
    "left and right": (lambda a: np.flip(a, 1), lambda t: t * [-1, 1]),
    "top and bottom": (lambda a: np.flip(a, 0), lambda t: t * [1, -1]),
    "a quarter turn": (lambda a: np.rot90(a), lambda t: t[..., ::-1] * [1, -1]),
    "half a turn": (lambda a: np.rot90(a, 2), lambda t: t),
    "the diagonal": (lambda a: np.swapaxes(a, 0, 1), lambda t: t[..., ::-1]),
}


def in_a_ground(height, width, top, left, picture=None):
    """A photograph before a uniform ground."""
    picture = photo()[..., 0] if picture is None else picture
    code = np.full((height, width), 90, np.float32)
    code[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
    return code


def filled_of(code, fill):
    return flow_fill(*gradient(np.ascontiguousarray(code)), fill)


def assert_same_directions(one, other, limit=0.1):
    """p99 within a tenth of a degree, and hardly a pixel off by more: the middle of a vortex may turn."""
    degrees = degrees_between(one, other)
    assert np.quantile(degrees, 0.99) < limit
    assert (degrees > 2).mean() < 1e-3


@pytest.mark.parametrize("fill", [0.0, 4.0, 30.0])
@pytest.mark.parametrize("size", [(201, 233), (200, 256), (131, 322), (97, 96)])
@pytest.mark.parametrize("flip", FLIPS)
def test_a_flipped_or_turned_picture_has_the_flipped_or_turned_flow(flip, size, fill):
    picture, tangents = FLIPS[flip]
    code = in_a_ground(*size, 21, 17)
    expected = picture(tangents(filled_of(code, fill)))
    assert_same_directions(filled_of(picture(code), fill), expected)


@pytest.mark.parametrize("fill", [0.0, 4.0, 30.0])
@pytest.mark.parametrize(("down", "right"), [(0, 1), (1, 0), (1, 1), (2, 3), (5, 0), (7, 11), (32, 64)])
def test_a_picture_that_moves_takes_its_flow_with_it(down, right, fill):
    here = filled_of(in_a_ground(241, 263, 71, 62), fill)
    there = filled_of(in_a_ground(241, 263, 71 + down, 62 + right), fill)
    assert_same_directions(there[down:, right:], here[: 241 - down, : 263 - right])


@pytest.mark.parametrize("fill", [0.0, 4.0])
@pytest.mark.parametrize("flip", FLIPS)
def test_noise_edges_and_points_in_any_position(flip, fill):
    picture, tangents = FLIPS[flip]
    rng = np.random.default_rng(8)
    y, x = np.mgrid[:90, :77]
    noise = rng.normal(100, 3, (90, 77))
    step = np.where(3 * x + y > 140, 200.0, 30.0)
    points = np.where(rng.random((90, 77)) < 0.01, 200.0, 30.0)
    # The tensors around a point cancel: there is little direction between points, and rounding shows in it.
    for shape, limit in ((noise, 0.1), (step, 0.1), (points, 0.2), (np.hypot(y - 40, x - 33), 0.1)):
        code = in_a_ground(163, 150, 37, 30, shape.astype(np.float32))
        assert_same_directions(filled_of(picture(code), fill), picture(tangents(filled_of(code, fill))), limit)


def test_a_wide_hole_is_filled_without_steps():
    filled = filled_of(in_a_ground(300, 300, 118, 118), 0.0)
    flat = np.ones((300, 300), bool)
    flat[110:190, 110:190] = False
    for axis in (0, 1):
        turn = degrees_between(filled, np.roll(filled, 1, axis))
        keep = flat & np.roll(flat, 1, axis)
        keep[0], keep[:, 0] = False, False
        assert np.quantile(turn[keep], 0.99) < 4  # degrees from one pixel to the next; 90 at the middle of a vortex
        assert np.median(turn[keep]) < 1


def test_what_goes_in_is_not_written_to():
    for code in (with_holes(20, 33), with_holes(8, 15)):
        tangent, magnitude = gradient(code)
        before = tangent.copy()
        filled = flow_fill(tangent, magnitude, 2.0)
        np.testing.assert_array_equal(tangent, before)
        np.testing.assert_array_equal(flow_fill(tangent, magnitude, 2.0, float(magnitude.max())), filled)


@pytest.mark.parametrize("fill", [0.0, 2.0])
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, fill):
    tangent, magnitude = gradient(with_holes(140, 75))
    one, *others = each_thread_count(lambda: flow_fill(tangent, magnitude, fill))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_confident_tangents_stay_to_the_bit():
    tangent, magnitude = gradient(photo())
    filled = flow_fill(tangent, magnitude, 4.0)
    confident = magnitude >= 4
    assert 0.1 < confident.mean() < 0.9
    np.testing.assert_array_equal(filled[confident], tangent[confident])


def test_a_hole_gets_the_direction_around_it():
    tangent = np.zeros((32, 32, 2), np.float32)
    tangent[:] = np.cos(0.7), np.sin(0.7)
    magnitude = np.full((32, 32), 5, np.float32)
    tangent[5:27, 8:30], magnitude[5:27, 8:30] = 0, 0
    filled = flow_fill(tangent, magnitude, 0)
    assert degrees_between(filled, [np.cos(0.7), np.sin(0.7)]).max() < 1e-4


def test_noise_leans_on_the_strong_edge_beside_it():
    rng = np.random.default_rng(5)
    angle = rng.uniform(0, np.pi, (32, 32))
    tangent = np.stack([np.cos(angle), np.sin(angle)], -1).astype(np.float32)
    magnitude = np.full((32, 32), 0.05, np.float32)
    tangent[:, 16], magnitude[:, 16] = (0, 1), 30
    filled = flow_fill(tangent, magnitude, 2.0)
    assert degrees_between(filled, [0, 1]).max() < 1


def test_nothing_to_lean_on_is_horizontal():
    filled = flow_fill(np.zeros((5, 7, 2), np.float32), np.zeros((5, 7), np.float32), 2.0)
    np.testing.assert_array_equal(filled, np.broadcast_to([1, 0], (5, 7, 2)))


@given(
    height=st.integers(1, 12),
    width=st.integers(1, 12),
    fill=st.sampled_from([0.0, 1e-6, 3.0, 1e6]),
    scale=st.sampled_from([1e-30, 1e-6, 1.0, 1e5, 1e36]),
    holes=st.floats(0, 1),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=100)
def test_every_tangent_is_a_unit_vector(height, width, fill, scale, holes, seed):
    rng = np.random.default_rng(seed)
    code = np.where(rng.random((height, width)) < holes, 0, rng.uniform(-1, 1, (height, width))) * scale
    filled = flow_fill(*gradient(code.astype(np.float32)), fill)
    np.testing.assert_allclose(np.linalg.norm(filled, axis=-1), 1, rtol=1e-6)
