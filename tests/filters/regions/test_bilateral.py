import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes.choices import BILATERAL_KERNELS as KERNELS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import bilateral
from tests.filters.flows import THIN, cases
from tests.naive import bilateral as naive


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("parameters", [(2, 10, 3), (2, 50, 2), (0.3, 10, 5), (5, 30, 1)])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_definition_in_float64(name, parameters, kernel):
    image, _ = cases()[name]
    smooth = bilateral(image, *parameters, kernel)
    assert smooth.dtype == np.float32
    np.testing.assert_allclose(smooth, naive.bilateral(image, *parameters, kernel), rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures_and_the_border_that_repeats(shape, kernel):
    image = np.random.default_rng(1).uniform(0, 100, (*shape, 3)).astype(np.float32)
    smooth = bilateral(image, 3, 50, 2, kernel)
    np.testing.assert_allclose(smooth, naive.bilateral(image, 3, 50, 2, kernel), rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
def test_with_any_colour_alike_it_is_a_gaussian_blur(kernel):
    image, _ = cases()["photo"]
    weights = np.exp(-(np.arange(-6, 7) ** 2) / 8)
    weights /= weights.sum()
    wide = np.pad(image.astype(float), ((6, 6), (6, 6), (0, 0)), "edge")
    rows = sum(w * wide[k : k + 64] for k, w in enumerate(weights))
    expected = sum(w * rows[:, k : k + 64] for k, w in enumerate(weights))
    np.testing.assert_allclose(bilateral(image, 2, 1e6, 1, kernel), expected, rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
def test_neighbours_are_weighted_by_alpha(kernel):
    image, _ = cases()["noise"]
    random = np.random.default_rng(4)
    alpha = random.random(image.shape[:2]).astype(np.float32)
    alpha[random.random(alpha.shape) < 0.3] = 0
    smooth = bilateral(image, 2, 60, 3, kernel, alpha)
    np.testing.assert_allclose(smooth, naive.bilateral(image, 2, 60, 3, kernel, alpha), rtol=0, atol=1e-3)
    np.testing.assert_array_equal(smooth[alpha == 0], image[alpha == 0])


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_colour_of_what_is_not_there_never_shows(kernel):
    image, _ = cases()["photo"]
    alpha = np.ones(image.shape[:2])
    alpha[:, 30:] = 0
    expected = bilateral(image, sigma_r=1e9, kernel=kernel, alpha=alpha)
    for poison in (1e6, 3e38):
        poisoned = np.where(alpha[..., None] > 0, image, poison).astype(np.float32)
        smooth = bilateral(poisoned, sigma_r=1e9, kernel=kernel, alpha=alpha)
        np.testing.assert_array_equal(smooth[:, :30], expected[:, :30])
        np.testing.assert_array_equal(smooth[:, 30:], poisoned[:, 30:])


def test_alpha_of_any_magnitude_gives_colours_of_the_picture():
    image, _ = cases()["noise"]
    alpha = np.random.default_rng(5).choice([0, -1, 1e-45, 1e-38, 1e-19, 1e-3, 1, 1e10], image.shape[:2])
    smooth = bilateral(image, 2, 1000, 3, alpha=alpha)
    assert np.isfinite(smooth).all()
    assert smooth.min() >= image.min() - 0.1
    assert smooth.max() <= image.max() + 0.1
    np.testing.assert_array_equal(bilateral(image, alpha=np.ones(image.shape[:2])), bilateral(image))


def test_sigma_0_and_0_iterations_are_copies():
    image, _ = cases()["photo"]
    for parameters in ({"sigma_d": 0}, {"iterations": 0}, {"sigma_d": 0, "kernel": "xy"}):
        smooth = bilateral(image, **parameters)
        np.testing.assert_array_equal(smooth, image)
        assert not np.shares_memory(smooth, image)


def test_full_has_no_axis_and_xy_has():
    image, _ = cases()["photo"]
    turned = np.ascontiguousarray(image.transpose(1, 0, 2))
    np.testing.assert_allclose(bilateral(turned), bilateral(image).transpose(1, 0, 2), rtol=0, atol=1e-3)
    difference = bilateral(turned, kernel="xy") - bilateral(image, kernel="xy").transpose(1, 0, 2)
    assert abs(difference).max() > 1


@given(
    color=st.tuples(*[st.floats(-1e4, 1e4, width=32)] * 3),
    sigma=st.floats(0, 20),
    r=st.floats(0, 1e300, exclude_min=True),
    kernel=st.sampled_from(KERNELS),
)
@settings(deadline=None, max_examples=40)
def test_constants_stay_exactly(color, sigma, r, kernel):
    image = np.full((6, 7, 3), color, np.float32)
    np.testing.assert_array_equal(bilateral(image, sigma, r, 2, kernel), image)


@given(r=st.floats(1e-3, 1e6), sigma=st.floats(0.01, 8), kernel=st.sampled_from(KERNELS))
@settings(deadline=None, max_examples=20)
def test_nothing_leaves_the_range_of_the_picture(r, sigma, kernel):
    image = cases()["noise"][0][:20, :20]
    smooth = bilateral(image, sigma, r, 2, kernel)
    assert smooth.min() >= image.min() - 1e-3
    assert smooth.max() <= image.max() + 1e-3


def test_any_memory_layout_dtype_and_width_gives_the_same():
    image, _ = cases()["photo"]
    expected = bilateral(image)
    np.testing.assert_array_equal(bilateral(np.asfortranarray(image)), expected)
    np.testing.assert_array_equal(bilateral(image.astype(np.uint8)), expected)
    wide = np.tile(image[:12], (1, 10, 1))  # more columns than a block has
    np.testing.assert_allclose(bilateral(wide, iterations=1), naive.bilateral(wide, 2, 10, 1), rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, kernel):
    image, _ = cases()["noise"]
    one, *others = each_thread_count(lambda: bilateral(image, sigma_r=60, kernel=kernel))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"codes": np.zeros((4, 5))}, "codes"),
        ({"codes": np.full((4, 5, 3), np.nan)}, "codes"),
        ({"sigma_d": -1}, "sigma_d"),
        ({"sigma_r": 0}, "sigma_r"),
        ({"iterations": 1.0}, "iterations"),
        ({"kernel": "yx"}, "kernel"),
        ({"alpha": np.ones((5, 4))}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        bilateral(**({"codes": np.zeros((4, 5, 3))} | arguments))
    assert error.value.parameter == parameter
