import numpy as np
import pytest

from flowabs_nodes.filters.flow.flow_resolution import enlarged_flow, reduced_flow
from tests.filters.flows import random_flow
from tests.naive import resolution as naive

SHAPES = [(1, 1), (1, 23), (23, 1), (17, 40), (36, 52)]
FACTORS = [2, 4]


def smooth_flow(height, width):
    y, x = np.mgrid[:height, :width]
    angle = 1 + x / 30 - (y / 20) ** 2
    return np.stack([np.cos(angle), np.sin(angle)], -1).astype(np.float32)


def doubled(flow):
    return np.stack(naive.angles(flow), -1)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_reduced_is_the_mean_of_double_angles(shape, factor):
    flow = smooth_flow(*shape)
    mean = naive.reduced(doubled(flow), factor)
    small = reduced_flow(flow, factor)
    np.testing.assert_allclose(np.linalg.norm(small, axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose(doubled(small), mean / np.linalg.norm(mean, axis=-1, keepdims=True), atol=1e-5)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("shape", SHAPES)
def test_enlarged_is_the_cubic_of_double_angles(shape, factor):
    small = smooth_flow(*(-(-size // factor) for size in shape))
    expected = np.stack([naive.enlarged(each, factor, *shape) for each in naive.angles(small)], -1)
    large = enlarged_flow(small, factor, *shape)
    assert large.shape == (*shape, 2)
    np.testing.assert_allclose(np.linalg.norm(large, axis=-1), 1, atol=1e-6)
    np.testing.assert_allclose(doubled(large), expected / np.linalg.norm(expected, axis=-1, keepdims=True), atol=1e-5)


@pytest.mark.parametrize("factor", FACTORS)
@pytest.mark.parametrize("angle", [0, 0.3, np.pi / 4, np.pi / 2, 2.5])
def test_the_flow_of_a_straight_edge_is_exact(factor, angle):
    flow = np.tile(np.float32([np.cos(angle), np.sin(angle)]), (25, 39, 1))
    back = enlarged_flow(reduced_flow(flow, factor), factor, 25, 39)
    np.testing.assert_allclose(np.abs((back * flow).sum(-1)), 1, atol=1e-6)
    np.testing.assert_allclose(back[..., 0] * flow[..., 1], back[..., 1] * flow[..., 0], atol=1e-6)


@pytest.mark.parametrize("factor", FACTORS)
def test_signs_and_lengths_have_no_meaning(factor):
    flow = smooth_flow(24, 36)
    other = flow * np.random.default_rng(1).choice([-2, -1, 0.5, 1], (24, 36, 1)).astype(np.float32)
    np.testing.assert_allclose(reduced_flow(other, factor), reduced_flow(flow, factor), atol=1e-5)


@pytest.mark.parametrize("factor", FACTORS)
def test_zero_tangents_count_for_nothing(factor):
    flow = np.zeros((24, 36, 2), np.float32)
    flow[::4, ::4] = [0.6, 0.8]
    small = reduced_flow(flow, factor)
    there = (small != 0).any(-1)
    assert there.mean() == (1 if factor == 4 else 0.25)
    np.testing.assert_allclose(small[there], np.tile([0.6, 0.8], (there.sum(), 1)), atol=1e-6)
    assert (enlarged_flow(np.zeros((6, 9, 2), np.float32), factor, 6 * factor, 9 * factor) == 0).all()


def test_a_pixel_between_opposite_double_angles_takes_its_blocks_tangent():
    small = np.zeros((4, 20, 2), np.float32)
    small[:, :, 0] = 1
    small[1] = [0, 1]  # cos 2θ is -1 among 1s: no pixel may end without a direction
    large = enlarged_flow(small, 2, 8, 40)
    np.testing.assert_allclose(np.linalg.norm(large, axis=-1), 1, atol=1e-6)


@pytest.mark.parametrize("factor", FACTORS)
def test_any_number_of_threads_gives_the_same_bits(factor, each_thread_count):
    flow = random_flow((130, 70), 3)
    small = each_thread_count(lambda: reduced_flow(flow, factor))
    large = each_thread_count(lambda: enlarged_flow(small[0], factor, 130, 70))
    for results in (small, large):
        for result in results[1:]:
            np.testing.assert_array_equal(result, results[0])
