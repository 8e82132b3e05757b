import numpy as np
import pytest

from flowabs_nodes.choices import ORIENTED_KERNELS as KERNELS
from flowabs_nodes.choices import SAMPLINGS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import bilateral_oriented, fbl
from flowabs_nodes.filters.regions.bilateral_oriented import curvature
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import bilateral as naive


def circles(size=61, centre=(70.0, -20.0)):
    """A flow along circles, and the radius of each pixel's."""
    y, x = np.mgrid[:size, :size]
    dx, dy = x - centre[0], y - centre[1]
    radius = np.hypot(dx, dy)
    return np.stack([-dy / radius, dx / radius], -1).astype(np.float32), radius


@pytest.mark.parametrize("sampling", SAMPLINGS)
@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("parameters", [(2, 10, 0.5, 10, 5), (3, 15, 2, 10, 3), (20, 1000, 15, 0.5, 1)])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_equations_in_float64(name, parameters, kernel, sampling):
    image, flow = cases()[name]
    smooth = bilateral_oriented(image, flow, *parameters, kernel, sampling=sampling)
    expected = naive.bilateral_oriented(image, flow, *parameters, kernel, sampling)
    assert smooth.dtype == np.float32
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape, kernel):
    image = np.random.default_rng(1).uniform(0, 100, (*shape, 3)).astype(np.float32)
    flow = random_flow(shape, 2)
    smooth = bilateral_oriented(image, flow, 2, 50, 2, 50, 2, kernel)
    expected = naive.bilateral_oriented(image, flow, 2, 50, 2, 50, 2, kernel)
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
def test_readings_are_weighted_by_alpha(kernel):
    image, flow = cases()["noise"]
    random = np.random.default_rng(4)
    alpha = random.random(flow.shape[:2]).astype(np.float32)
    alpha[random.random(alpha.shape) < 0.3] = 0
    smooth = bilateral_oriented(image, flow, 2, 30, 1, 30, 3, kernel, alpha)
    expected = naive.bilateral_oriented(image, flow, 2, 30, 1, 30, 3, kernel, alpha=alpha)
    np.testing.assert_allclose(smooth, expected, rtol=0, atol=2e-3)
    np.testing.assert_array_equal(smooth[alpha == 0], image[alpha == 0])


def test_where_the_flow_is_straight_line_arc_and_curve_are_one():
    image, flow = cases()["photo"][0], np.zeros((64, 64, 2), np.float32)
    flow[..., 0], flow[..., 1] = 0.6, 0.8
    line = bilateral_oriented(image, flow)
    np.testing.assert_array_equal(bilateral_oriented(image, flow, kernel="arc"), line)
    np.testing.assert_allclose(fbl(image, flow), line, rtol=0, atol=1e-3)


def test_curvature_of_circles_is_one_over_their_radius():
    flow, radius = circles()
    kappa = curvature(flow)
    np.testing.assert_allclose(kappa[1:-1, 1:-1], 1 / radius[1:-1, 1:-1], rtol=1e-3)
    np.testing.assert_allclose(naive.curvature(flow), kappa, rtol=0, atol=1e-12)


def test_an_arc_stays_on_a_circle_that_a_line_leaves():
    flow, radius = circles(41, (20.0, -8.0))
    rings = np.repeat(50 + 50 * np.sin(radius / 2)[..., None], 3, axis=2)
    off = {}
    for kernel in KERNELS:
        smooth = bilateral_oriented(rings, flow, 3, 1000, 0, 10, 1, kernel, sampling="bilinear")
        off[kernel] = abs(smooth - rings)[14:27, 14:27].mean()
    assert off["arc"] < 0.3 * off["line"]


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_sign_of_a_flow_has_no_meaning(kernel):
    image, flow = cases()["noise"]
    signs = np.random.default_rng(3).choice([-1, 1], (*flow.shape[:2], 1)).astype(np.float32)
    one, other = (bilateral_oriented(image, each, 2, 60, kernel=kernel) for each in (flow, flow * signs))
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-3)


@pytest.mark.parametrize("kernel", KERNELS)
def test_flow_of_any_magnitude_gives_colours_of_the_picture(kernel):
    image, flow = cases()["noise"]
    flow = flow * np.random.default_rng(5).choice([1e-45, 1e-10, 1, 100, 1e30], (*flow.shape[:2], 1))
    smooth = bilateral_oriented(image, flow, 2, 1000, 2, 1000, 3, kernel, sampling="bilinear")
    assert smooth.min() >= image.min() - 0.1
    assert smooth.max() <= image.max() + 0.1


def test_sigma_0_leaves_a_pass_out_and_constants_stay_exactly():
    image, flow = cases()["photo"]
    np.testing.assert_array_equal(bilateral_oriented(image, flow, sigma_e=0, sigma_g=0), image)
    np.testing.assert_array_equal(bilateral_oriented(image, flow, iterations=0), image)
    np.testing.assert_array_equal(bilateral_oriented(image, flow, sigma_e=0), fbl(image, flow, sigma_e=0))
    flat = np.full_like(image, 12.3)
    np.testing.assert_array_equal(bilateral_oriented(flat, flow, kernel="arc", sampling="bilinear"), flat)


@pytest.mark.parametrize("kernel", KERNELS)
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, kernel):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: bilateral_oriented(image, flow, kernel=kernel))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"codes": np.zeros((4, 5))}, "codes"),
        ({"flow": np.zeros((4, 6, 2))}, "flow"),
        ({"sigma_e": -1}, "sigma_e"),
        ({"r_e": 0}, "r_e"),
        ({"sigma_g": np.inf}, "sigma_g"),
        ({"r_g": -1}, "r_g"),
        ({"iterations": -1}, "iterations"),
        ({"kernel": "curve"}, "kernel"),
        ({"sampling": "cubic"}, "sampling"),
        ({"alpha": np.full((4, 5), np.nan)}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        bilateral_oriented(**({"codes": np.zeros((4, 5, 3)), "flow": np.zeros((4, 5, 2))} | arguments))
    assert error.value.parameter == parameter
