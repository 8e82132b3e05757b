import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, measure_reference
from flowabs_nodes.filters.flow.etf import etf_and_reference
from flowabs_nodes.filters.flow.gradient import gradient
from tests.filters.pictures import noise, photo
from tests.naive import etf as naive

GREY = photo().mean(-1)


def shapes(max_side=9):
    return st.tuples(st.integers(1, max_side), st.integers(1, max_side))


def codes(shape):
    return arrays(np.float32, shape, elements=st.floats(-1000, 1000, width=32))


small_pictures = shapes().flatmap(codes)


@pytest.mark.parametrize("code", [GREY, photo(), noise(140, 41)], ids=["photo", "colour", "noise"])
@pytest.mark.parametrize(
    ("radius", "kernel", "fill"),
    [(5.0, "full", None), (7.5, "full", 2.0), (2.0, "full", 0.0), (5.0, "separable", None)],
)
def test_equals_the_equations_in_float64(code, radius, kernel, fill):
    flow = etf(code, radius, 3, kernel, fill=fill)
    error = naive.degrees_between(flow, naive.etf(code, radius, 3, kernel, fill=fill))
    assert flow.dtype == np.float32
    assert np.median(error) < 1e-4
    assert error.max() < 0.05


def test_a_large_kernel_in_coarse_fixed_point_is_still_exact():
    code = noise(90, 100)
    error = naive.degrees_between(etf(code, 60.0, 1, fill=None), naive.etf(code, 60.0, 1))
    assert np.median(error) < 1e-3
    assert error.max() < 0.05


@pytest.mark.parametrize("reference", [16.0, 0])
def test_reference_of_a_shot(reference):
    error = naive.degrees_between(
        etf(GREY, gradient_reference=reference, fill=None), naive.etf(GREY, 5, 3, reference=reference)
    )
    assert np.median(error) < 1e-4


def test_a_measured_reference_may_be_handed_back():
    measured = measure_reference(GREY, "p99", pre_blur=1.0)
    np.testing.assert_array_equal(
        etf(GREY, pre_blur=1.0, gradient_reference="p99"), etf(GREY, pre_blur=1.0, gradient_reference=measured)
    )
    flat = np.zeros((4, 4))
    np.testing.assert_array_equal(etf(flat), etf(flat, gradient_reference=measure_reference(flat, "max")))


def test_weak_edges_turn_to_follow_a_strong_one():
    code = np.where(np.arange(40) < 20, 0, 255) + noise(40, 40) * 0.05
    before = naive.degrees_between(etf(code, iterations=0), [0, 1])
    after = naive.degrees_between(etf(code, iterations=3), [0, 1])
    assert before[:, [17, 18, 21, 22]].mean() > 35
    assert after[:, [17, 18, 21, 22]].mean() < 7
    assert after[:, 19:21].mean() < 1


@given(code=small_pictures, radius=st.floats(0, 12), kernel=st.sampled_from(["full", "separable"]))
@settings(deadline=None, max_examples=100)
def test_tangents_are_unit_or_zero_without_fill(code, radius, kernel):
    length = np.linalg.norm(etf(code, radius, 2, kernel), axis=-1)
    np.testing.assert_allclose(length, 1, rtol=1e-6)
    length = np.linalg.norm(etf(code, radius, 2, kernel, fill=None), axis=-1)
    np.testing.assert_allclose(length[length > 0], 1, rtol=1e-6)
    np.testing.assert_array_equal(length > 0, gradient(code).magnitude > 0)


@given(code=small_pictures, radius=st.floats(0, 12))
@settings(deadline=None, max_examples=100)
def test_a_turned_picture_has_a_turned_flow(code, radius):
    code = np.round(code)  # gradients that are exact: what is zero one way round is zero the other
    flow = etf(code, radius, fill=None)
    turned = etf(np.rot90(code), radius, fill=None)
    expected = np.rot90(np.stack([flow[..., 1], -flow[..., 0]], -1))  # (x, y) -> (y, -x), y down
    assert naive.degrees_between(turned, expected).max() < 0.05
    transposed = etf(code.T, radius, fill=None)
    assert naive.degrees_between(transposed, flow.transpose(1, 0, 2)[..., ::-1]).max() < 0.05


@pytest.mark.parametrize("code", [GREY, photo()], ids=["photo", "colour"])
def test_a_turned_photo_has_a_turned_flow_fill_and_pre_blur_included(code):
    options = {"pre_blur": 1.0, "fill": 2.0, "gradient_reference": "p99"}
    flow = etf(code, **options)
    turned = etf(np.rot90(code), **options)
    error = naive.degrees_between(turned, np.rot90(np.stack([flow[..., 1], -flow[..., 0]], -1)))
    assert np.quantile(error, 0.99) < 0.01


@given(code=small_pictures, exponent=st.integers(-60, 90), radius=st.floats(0, 12))
@settings(deadline=None, max_examples=50)
def test_scale_and_sign_of_the_picture_change_nothing(code, exponent, radius):
    code = np.round(code)  # so that no scale loses a bit
    flow = etf(code, radius)
    np.testing.assert_array_equal(flow, etf(code * np.float32(2.0**exponent), radius))
    np.testing.assert_array_equal(naive.degrees_between(flow, etf(-code, radius)), 0)


@pytest.mark.parametrize("kernel", ["full", "separable"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 17), (17, 1), (2, 2), (1, 1, 3), (5, 8, 3)])
def test_radius_may_exceed_the_picture(shape, kernel):
    code = np.random.default_rng(2).uniform(0, 255, shape).astype(np.float32)
    flow = etf(code, 1000, kernel=kernel)
    np.testing.assert_array_equal(flow, etf(code, 40, kernel=kernel))
    np.testing.assert_array_equal(flow, etf(code, 1e30, kernel=kernel))
    np.testing.assert_allclose(np.linalg.norm(flow, axis=-1), 1, rtol=1e-6)


@pytest.mark.parametrize("radius", [0, 0.5, 1])
def test_a_kernel_of_one_pixel_changes_nothing(radius):
    np.testing.assert_array_equal(etf(GREY, radius), etf(GREY, iterations=0))


def test_the_disc_is_open():
    np.testing.assert_array_equal(etf(GREY, 3.0, 1), etf(GREY, 2.99, 1))  # no pixel lies between 2.83 and 3
    assert (etf(GREY, 3.0, 1) != etf(GREY, 3.01, 1)).any()


@pytest.mark.parametrize("shape", [(1, 1), (6, 9), (6, 9, 3)])
def test_an_image_without_gradient(shape):
    code = np.full(shape, 42.5)
    np.testing.assert_array_equal(etf(code), np.broadcast_to([1, 0], (*shape[:2], 2)))
    assert not etf(code, fill=None).any()


def test_high_dynamic_range_and_tiny_values_stay_finite():
    for scale in (1e-38, 1e-6, 1e5, 1e36):
        flow = etf(photo() * np.float32(scale), pre_blur=1.0, fill=2.0, gradient_reference="p99")
        np.testing.assert_allclose(np.linalg.norm(flow, axis=-1), 1, rtol=1e-6)


@pytest.mark.parametrize("options", [{}, {"kernel": "separable"}, {"fill": 3.0, "pre_blur": 1.0}])
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, options):
    code = noise(150, 50)  # more rows than share their running sums
    one, *others = each_thread_count(lambda: etf(code, 6.0, **options))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("radius", [2.0, 8.0, 9.5, 20.0])
@pytest.mark.parametrize("shape", [(33, 50), (7, 16), (40, 15), (3, 90)])
def test_every_radius_and_size_in_float64(shape, radius):
    code = noise(*shape)
    code[: shape[0] // 2, 5:12] = 0  # with tangents missing
    error = naive.degrees_between(etf(code, radius, 2, fill=None), naive.etf(code, radius, 2))
    assert np.median(error) < 1e-4
    assert error.max() < 0.05


def test_a_tiny_reference_makes_every_gradient_a_strong_one():
    error = naive.degrees_between(
        etf(GREY, gradient_reference=1e-300, fill=None), naive.etf(GREY, 5, 3, reference=1e-300)
    )
    assert np.median(error) < 1e-4


def test_arguments_are_left_alone():
    code = photo()
    before = code.copy()
    etf(code, pre_blur=1.0, fill=2.0)
    np.testing.assert_array_equal(code, before)


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("code", np.zeros((3, 3, 2))),
        ("code", np.zeros((3, 3), complex)),
        ("code", np.array([[0, np.inf]])),
        ("radius", -1),
        ("radius", np.nan),
        ("iterations", 1.0),
        ("iterations", -1),
        ("kernel", "fulll"),
        ("pre_blur", -0.1),
        ("gradient_reference", "p100.5"),
        ("fill", -1.0),
        ("fill", "none"),
    ],
)
def test_errors_name_the_argument(parameter, value):
    arguments = {"code": np.zeros((3, 3)), parameter: value}
    with pytest.raises(ArgumentError, match=parameter) as error:
        etf(**arguments)
    assert error.value.parameter == parameter


@pytest.mark.parametrize("iterations", [0, 1])
def test_the_reference_that_was_used_comes_back(iterations):
    options = {"radius": 3, "iterations": iterations, "kernel": "full", "pre_blur": 1.0, "fill": 0.0, "adaptive": False}
    flow, reference = etf_and_reference(GREY, gradient_reference="p99", **options)
    assert reference == measure_reference(GREY, "p99", pre_blur=1.0)
    np.testing.assert_array_equal(flow, etf(GREY, gradient_reference="p99", **options))
    assert etf_and_reference(GREY, gradient_reference=16, **options)[1] == 16
