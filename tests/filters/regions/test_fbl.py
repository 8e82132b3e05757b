import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import fbl
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import fbl as naive


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize(
    "parameters", [(2, 10, 0.5, 10, 5), (3, 15, 2, 10, 3), (2, 50, 0.3, 10, 2), (20, 1000, 15, 0.5, 1)]
)
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_equations_in_float64(name, parameters, sampling):
    image, flow = cases()[name]
    smooth = fbl(image, flow, *parameters, sampling=sampling)
    assert smooth.dtype == np.float32
    np.testing.assert_allclose(smooth, naive.fbl(image, flow, *parameters, sampling), rtol=0, atol=1e-3)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape, sampling):
    image = np.random.default_rng(1).uniform(0, 100, (*shape, 3)).astype(np.float32)
    flow = random_flow(shape, 2)
    smooth = fbl(image, flow, 2, 50, 2, 50, 2, sampling)
    np.testing.assert_allclose(smooth, naive.fbl(image, flow, 2, 50, 2, 50, 2, sampling), rtol=0, atol=1e-3)


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_readings_are_weighted_by_alpha(name, sampling):
    image, flow = cases()[name]
    random = np.random.default_rng(4)
    alpha = random.random(flow.shape[:2]).astype(np.float32)
    alpha[random.random(alpha.shape) < 0.3] = 0
    smooth = fbl(image, flow, 2, 30, 1, 30, 3, sampling, alpha)
    np.testing.assert_allclose(smooth, naive.fbl(image, flow, 2, 30, 1, 30, 3, sampling, alpha), rtol=0, atol=2e-3)
    np.testing.assert_array_equal(smooth[alpha == 0], image[alpha == 0])


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_the_colour_of_what_is_not_there_never_shows(sampling):
    image, flow = cases()["photo"]
    alpha = np.ones(flow.shape[:2])
    alpha[:, 30:] = 0
    poisoned = np.where(alpha[..., None] > 0, image, 1e6)
    smooth = fbl(poisoned, flow, r_e=1e9, r_g=1e9, sampling=sampling, alpha=alpha)
    np.testing.assert_allclose(
        smooth[:, :30], fbl(image, flow, r_e=1e9, r_g=1e9, sampling=sampling, alpha=alpha)[:, :30]
    )
    assert smooth[:, :30].max() <= image.max() + 1e-3
    np.testing.assert_array_equal(smooth[:, 30:], poisoned[:, 30:].astype(np.float32))


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_alpha_and_flow_of_any_magnitude_give_colours_of_the_picture(sampling):
    image, flow = cases()["noise"]
    random = np.random.default_rng(5)
    alpha = random.choice([0, 1e-45, 1e-38, 1e-19, 1e-10, 1e-3, 1, 1e10], flow.shape[:2])
    flow = flow * random.choice([1e-45, 1e-30, 1e-10, 1, 100], flow.shape)
    smooth = fbl(image, flow, 2, 1000, 2, 1000, 3, sampling, alpha)
    assert np.isfinite(smooth).all()
    assert smooth.min() >= image.min() - 0.1
    assert smooth.max() <= image.max() + 0.1


def test_alpha_1_is_no_alpha_and_scaling_alpha_changes_nothing():
    image, flow = cases()["photo"]
    expected = fbl(image, flow)
    np.testing.assert_array_equal(fbl(image, flow, alpha=np.ones(flow.shape[:2])), expected)
    np.testing.assert_allclose(fbl(image, flow, alpha=np.full(flow.shape[:2], 0.3)), expected, rtol=0, atol=1e-3)
    for tiny in (0.0, -0.5, 1e-38):
        np.testing.assert_array_equal(fbl(image, flow, alpha=np.full(flow.shape[:2], tiny)), image)


def test_sigma_0_leaves_a_pass_out():
    image, flow = cases()["photo"]
    for parameters in [(2, 20, 0, 10, 2), (0, 20, 1, 10, 2)]:
        expected = naive_of_one_pass(image, flow, *parameters)
        np.testing.assert_allclose(fbl(image, flow, *parameters), expected, rtol=0, atol=1e-3)
    np.testing.assert_array_equal(fbl(image, flow, sigma_e=0, sigma_g=0), image)


def naive_of_one_pass(image, flow, sigma_e, r_e, sigma_g, r_g, iterations):
    """A very small sigma reads the centre alone."""
    return naive.fbl(image, flow, sigma_e or 1e-3, r_e, sigma_g or 1e-3, r_g, iterations)


def test_0_iterations_is_a_copy():
    image, flow = cases()["photo"]
    smooth = fbl(image, flow, iterations=0)
    np.testing.assert_array_equal(smooth, image)
    assert not np.shares_memory(smooth, image)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_an_edge_between_colours_that_differ_stays(sampling):
    image = np.zeros((20, 20, 3), np.float32)
    image[:, 10:] = 100, 20, -40
    image += np.random.default_rng(0).normal(0, 2, image.shape)
    flow = np.zeros((20, 20, 2))
    flow[..., 1] = 1
    smooth = fbl(image, flow, 3, 15, 2, 15, 3, sampling)
    assert abs(smooth[:, 10:].mean((0, 1)) - smooth[:, :10].mean((0, 1)) - [100, 20, -40]).max() < 1.5
    assert smooth[:, :10].std() < image[:, :10].std() / 3


@given(
    color=st.tuples(*[st.floats(-1e4, 1e4, width=32)] * 3),
    sigma_e=st.floats(0, 20),
    sigma_g=st.floats(0, 20),
    r=st.floats(0, 1e300, exclude_min=True),
    sampling=st.sampled_from(SAMPLINGS),
    scale=st.sampled_from([0, 1, 1e30]),
)
@settings(deadline=None, max_examples=40)
def test_constants_stay_exactly(color, sigma_e, sigma_g, r, sampling, scale):
    image = np.full((6, 7, 3), color, np.float32)
    smooth = fbl(image, random_flow((6, 7)) * np.float32(scale), sigma_e, r, sigma_g, r, 2, sampling)
    np.testing.assert_array_equal(smooth, image)


@given(r=st.floats(1e-3, 1e6), sigma=st.floats(0.01, 10), sampling=st.sampled_from(SAMPLINGS))
@settings(deadline=None, max_examples=20)
def test_nothing_leaves_the_range_of_the_picture(r, sigma, sampling):
    image, flow = cases()["noise"]
    smooth = fbl(image[:20, :20], flow[:20, :20], sigma, r, sigma, r, 2, sampling)
    assert smooth.min() >= image[:20, :20].min() - 1e-3
    assert smooth.max() <= image[:20, :20].max() + 1e-3


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_the_sign_of_a_flow_has_no_meaning(sampling):
    image, flow = cases()["noise"]
    signs = np.random.default_rng(3).choice([-1, 1], (*flow.shape[:2], 1)).astype(np.float32)
    np.testing.assert_allclose(
        fbl(image, flow * signs, sampling=sampling), fbl(image, flow, sampling=sampling), rtol=0, atol=1e-3
    )


def test_any_memory_layout_and_dtype_gives_the_same():
    image, flow = cases()["photo"]
    expected = fbl(image, flow)
    np.testing.assert_array_equal(fbl(np.asfortranarray(image), np.asfortranarray(flow)), expected)
    np.testing.assert_array_equal(fbl(image.astype(np.uint8), flow.astype(np.float64)), expected)


@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, sampling):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: fbl(image, flow, sigma_g=2, sampling=sampling))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"codes": np.zeros((4, 5))}, "codes"),
        ({"codes": np.full((4, 5, 3), np.nan)}, "codes"),
        ({"flow": np.zeros((4, 6, 2))}, "flow"),
        ({"sigma_e": -1}, "sigma_e"),
        ({"r_e": 0}, "r_e"),
        ({"sigma_g": np.inf}, "sigma_g"),
        ({"r_g": -1}, "r_g"),
        ({"iterations": -1}, "iterations"),
        ({"iterations": True}, "iterations"),
        ({"sampling": "cubic"}, "sampling"),
        ({"alpha": np.ones((5, 4))}, "alpha"),
        ({"alpha": np.full((4, 5), np.nan)}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        fbl(**({"codes": np.zeros((4, 5, 3)), "flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter


@pytest.mark.parametrize("length", [0, 0.5, 1, 6, 7, 1e30])
@pytest.mark.parametrize("shape", [(30, 41), (1, 16), (9, 15)])
@pytest.mark.parametrize("sigma_e", [2.0, 16 / 3, 5.5])
def test_walks_that_are_written_down_lead_to_the_same_pixels(sigma_e, shape, length, monkeypatch):
    random = np.random.default_rng(6)
    image = random.uniform(0, 100, (*shape, 3)).astype(np.float32)
    flow = random_flow(shape, 7) * np.float32(length)
    smooth = fbl(image, flow, sigma_e, 50, 0, iterations=2)
    monkeypatch.setattr("flowabs_nodes.sampling.chain_code.MOST_STEPS", 0)
    np.testing.assert_array_equal(smooth, fbl(image, flow, sigma_e, 50, 0, iterations=2))


@pytest.mark.parametrize("alpha", [None, np.random.default_rng(5).uniform(0, 1, (300, 37)).round(1)])
def test_bands_of_a_picture_brought_up_have_the_bits_of_the_whole(alpha, monkeypatch):
    rng = np.random.default_rng(4)
    codes = rng.uniform(0, 255, (300, 37, 3)).astype(np.float32)
    flow = random_flow((300, 37), 6)
    params = {"sigma_e": 3.0, "sigma_g": 1.0, "iterations": 2, "alpha": alpha, "working_scale": "1/2"}
    in_bands = fbl(codes, flow, **params)
    monkeypatch.setattr("flowabs_nodes.filters.regions.fbl.thread_count", lambda: 10_000)
    np.testing.assert_array_equal(in_bands, fbl(codes, flow, **params))
