import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import flow_blur, gaussian
from flowabs_nodes.filters.flow.flow_blur import along
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import streamline as naive


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("sigma", [0.1, 2.0, 20.0])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_eq_11_in_float64(name, sigma, sampling):
    image, flow = cases()[name]
    blurred = flow_blur(image, flow, sigma, sampling)
    np.testing.assert_allclose(blurred, naive.along(image, flow, sigma, sampling), rtol=0, atol=2e-4)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape, sampling):
    image = np.random.default_rng(1).uniform(0, 255, shape).astype(np.float32)
    flow = random_flow(shape, 2)
    blurred = flow_blur(image, flow, 3.0, sampling)
    np.testing.assert_allclose(blurred, naive.along(image, flow, 3.0, sampling), rtol=0, atol=2e-4)


@pytest.mark.parametrize("channels", [(), (1,), (2,), (3,), (4,)])
def test_each_channel_is_blurred_alone(channels):
    flow = random_flow((9, 11))
    image = np.random.default_rng(1).random((9, 11, *channels)).astype(np.float32)
    blurred = flow_blur(image, flow)
    assert blurred.shape == image.shape
    assert blurred.dtype == np.float32
    for c in np.ndindex(channels):
        np.testing.assert_array_equal(blurred[(..., *c)], flow_blur(image[(..., *c)], flow))


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_along_a_straight_flow_a_point_becomes_the_gaussian(sampling):
    point = np.zeros((5, 41))
    point[2, 20] = 1
    flow = np.zeros((5, 41, 2))
    flow[..., 0] = 1
    blurred = flow_blur(point, flow, 2.0, sampling)
    np.testing.assert_allclose(blurred[2, 14:27], naive.gaussian(2.0, 6), rtol=1e-6)
    assert blurred.sum() == pytest.approx(1)
    assert np.count_nonzero(blurred) == 13


def distances(flow, steps):
    """How far from pixel 20 of a row the nearest pixels are that are read after 1 .. ``steps`` steps, either way."""
    squares = np.arange(41, dtype=np.float32)[None, None] ** 2
    found = []
    for s in range(1, steps + 1):
        one = np.zeros(s + 1)
        one[s] = 1
        total = along(squares, flow, one, "nearest")[0, 0, 20]  # (20 + d)^2 + (20 - d)^2
        found.append(round(np.sqrt(total / 2 - 400)))
    return found


def test_offsets_round_half_to_even():
    flow = np.zeros((1, 41, 2), np.float32)
    flow[..., 0] = 0.5
    assert distances(flow, 7) == [0, 1, 2, 2, 2, 3, 4]


def test_tangents_turn_round_to_go_on_the_same_way():
    flow = np.zeros((1, 41, 2), np.float32)
    flow[..., 0] = np.where(np.arange(41) % 2, 1, -1)
    assert distances(flow, 5) == [1, 2, 3, 4, 5]


def test_a_zero_tangent_stops_the_streamline():
    flow = np.zeros((1, 41, 2), np.float32)
    flow[..., 0] = 1
    flow[0, [17, 23]] = 0
    assert distances(flow, 5) == [1, 2, 3, 3, 3]


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_where_the_flow_is_zero_nothing_changes(sampling):
    image, flow = cases()["photo"]
    np.testing.assert_allclose(flow_blur(image, 0 * flow, 3.0, sampling), image, rtol=1e-6)


def test_sigma_0_is_a_copy():
    image, flow = cases()["photo"]
    blurred = flow_blur(image, flow, 0)
    np.testing.assert_array_equal(blurred, image)
    assert not np.shares_memory(blurred, image)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_the_sign_of_a_flow_has_no_meaning(sampling):
    image, flow = cases()["noise"]
    signs = np.random.default_rng(3).choice([-1, 1], (*flow.shape[:2], 1)).astype(np.float32)
    np.testing.assert_allclose(
        flow_blur(image, flow * signs, 2.0, sampling), flow_blur(image, flow, 2.0, sampling), rtol=0, atol=1e-4
    )


@given(
    shape=st.sampled_from([(1, 1), (1, 7), (7, 1), (5, 4), (3, 2, 3)]),
    value=st.floats(-(2.0**100), 2.0**100, width=32),
    sigma=st.floats(0, 40),
    sampling=st.sampled_from(SAMPLINGS),
    scale=st.sampled_from([0, 1e-30, 1, 1e30]),
)
@settings(deadline=None, max_examples=50)
def test_constants_stay_whatever_the_flow(shape, value, sigma, sampling, scale):
    """Even with flows of no sensible length, which lead out of the picture at once."""
    blurred = flow_blur(np.full(shape, value), random_flow(shape) * np.float32(scale), sigma, sampling)
    np.testing.assert_allclose(blurred, np.float32(value), rtol=1e-5, atol=1e-36)


def test_any_memory_layout_and_dtype_gives_the_same():
    image, flow = cases()["photo"]
    expected = flow_blur(image, flow)
    np.testing.assert_array_equal(flow_blur(np.asfortranarray(image), np.asfortranarray(flow)), expected)
    np.testing.assert_array_equal(flow_blur(image.astype(np.uint8), flow.astype(np.float64)), expected)
    np.testing.assert_array_equal(flow_blur(np.repeat(image, 2, 1)[:, ::2], flow), expected)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, sampling):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: flow_blur(image, flow, 3.0, sampling))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"image": np.zeros(3)}, "image"),
        ({"image": np.zeros((4, 5, 5))}, "image"),
        ({"image": np.full((4, 5), np.nan)}, "image"),
        ({"flow": np.zeros((5, 4, 2))}, "flow"),
        ({"flow": np.zeros((4, 5, 3))}, "flow"),
        ({"flow": np.full((4, 5, 2), np.inf)}, "flow"),
        ({"sigma": -1}, "sigma"),
        ({"sigma": np.nan}, "sigma"),
        ({"sampling": "cubic"}, "sampling"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        flow_blur(**({"image": np.zeros((4, 5)), "flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter


@pytest.mark.parametrize("sampling", ["bilinear", "nearest"])
def test_the_longest_streamlines_end_in_the_border(sampling):
    image = np.linspace(0, 100, 30, dtype=np.float32) * np.ones((20, 1), np.float32)
    flow = np.broadcast_to(np.float32([1, 0]), (20, 30, 2))
    np.testing.assert_allclose(flow_blur(image, flow, 10_000, sampling), 50, atol=0.2)


@pytest.mark.parametrize("sigma", [1.0, 6.4])
@pytest.mark.parametrize("shape", [(150, 300), (70, 137), (40, 19), (3, 5), (200, 16)])
def test_ground_that_is_passed_over_has_the_same_bits(shape, sigma):
    random = np.random.default_rng(5)
    lines = np.ones((1, *shape), np.float32)
    for y, x in random.integers(0, shape, (4, 2)):
        lines[0, max(y - 2, 0) : y + 2, x : x + 30] = random.random()
    for flow in (random_flow(shape, 3), np.zeros((*shape, 2), np.float32)):
        expected = along(lines, flow, gaussian.half(sigma), "bilinear")
        for ground in (1.0, 0.25):  # the second is nowhere
            np.testing.assert_array_equal(along(lines, flow, gaussian.half(sigma), "bilinear", ground), expected)
    still = along(np.ones_like(lines), random_flow(shape, 3), gaussian.half(sigma), "bilinear", 1.0)
    np.testing.assert_array_equal(still, along(np.ones_like(lines), flow, gaussian.half(sigma), "bilinear"))
