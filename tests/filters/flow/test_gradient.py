import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import blur, measure_reference
from flowabs_nodes.filters.flow.gradient import gradient, measured
from tests.filters.pictures import noise, photo
from tests.naive import etf as naive


def test_ramp_has_its_slope():
    x = np.arange(8, dtype=np.float32)
    tangent, magnitude = gradient(np.tile(3 * x, (5, 1)))
    np.testing.assert_array_equal(magnitude[:, 1:-1], 3)
    np.testing.assert_array_equal(magnitude[:, [0, -1]], 1.5)  # the border is repeated
    np.testing.assert_array_equal(tangent, np.broadcast_to([0, 1], (5, 8, 2)))  # (-g.y, g.x) / |g|


@pytest.mark.parametrize("code", [noise(9, 14), photo()[:20, :30], photo()[:20, :30, :2]], ids=["noise", "rgb", "two"])
def test_equals_the_direct_reading(code):
    tangent, magnitude = gradient(code)
    expected_tangent, expected_magnitude = naive.gradient(code)
    np.testing.assert_allclose(magnitude, expected_magnitude, rtol=1e-6, atol=1e-6)
    there = expected_magnitude > 1e-6
    assert naive.degrees_between(tangent, expected_tangent)[there].max() < 1e-3
    np.testing.assert_allclose(np.linalg.norm(tangent, axis=-1)[there], 1, rtol=1e-6)


def test_one_channel_three_times_is_that_channel():
    code = noise(9, 14)
    one, three = gradient(code), gradient(np.repeat(code[..., None], 3, 2))
    np.testing.assert_allclose(three.magnitude, np.sqrt(3) * one.magnitude, rtol=1e-6)
    assert naive.degrees_between(one.tangent, three.tangent).max() < 1e-3


def test_no_gradient_has_no_direction():
    tangent, magnitude = gradient(np.full((4, 5, 3), 7, np.float32))
    assert not tangent.any()
    assert not magnitude.any()


def test_channels_that_pull_at_right_angles_have_strength_but_no_direction():
    x, y = np.meshgrid(np.arange(5, dtype=np.float32), np.arange(5, dtype=np.float32))
    tangent, magnitude = gradient(np.stack([x, y, np.zeros_like(x)], -1))
    assert magnitude[2, 2] == 1
    assert not tangent[2, 2].any()


@pytest.mark.parametrize("factor", [2.0**-80, 2.0**110])
@pytest.mark.parametrize("channels", [1, 3])
def test_scale_of_the_code_values_changes_nothing(factor, channels):
    code = photo()[:20, :30, :channels]
    tangent, magnitude = gradient(code)
    scaled_tangent, scaled_magnitude = gradient(code * np.float32(factor))
    np.testing.assert_array_equal(tangent, scaled_tangent)
    np.testing.assert_array_equal(magnitude * np.float32(factor), scaled_magnitude)


def test_the_largest_finite_picture_stays_finite():
    largest = np.finfo(np.float32).max
    code = np.where(np.indices((6, 6)).sum(0) % 4 < 2, largest, -largest).astype(np.float32)
    tangent, magnitude = gradient(code)
    assert np.isfinite(tangent).all()
    assert np.isfinite(magnitude).all()


def test_pre_blur_blurs_before():
    code = photo()
    for made, expected in zip(gradient(code, 1.5), gradient(blur(code, 1.5)), strict=True):
        np.testing.assert_array_equal(made, expected)


def test_measured_references():
    code = photo()[..., 0]
    magnitude = gradient(code).magnitude
    assert measure_reference(code, "max") == magnitude.max()
    assert measure_reference(code, "p100") == magnitude.max()
    assert measure_reference(code, "p0") == magnitude.min()
    assert measure_reference(code, "p99.5") == pytest.approx(np.percentile(magnitude, 99.5))
    assert measure_reference(code, 16) == 16.0
    assert measure_reference(code, "max", pre_blur=2.0) == gradient(code, 2.0).magnitude.max()
    assert measure_reference(np.zeros((3, 3)), "max") == 0


def test_what_is_told_of_a_gradient():
    for code in (noise(9, 14), photo(), np.zeros((3, 20), np.float32), noise(40, 3), np.diag(np.arange(20.0))):
        made, largest, everywhere = measured(np.asarray(code, np.float32))
        assert largest == made.magnitude.max()
        assert everywhere == made.tangent.any(axis=2).all()


@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (3, 15), (2, 16), (5, 17), (4, 33)])
def test_every_size_has_its_border_repeated(shape, channels):
    code = noise(*shape)[..., np.newaxis] * np.arange(1, channels + 1, dtype=np.float32)
    tangent, magnitude = gradient(code)
    expected_tangent, expected_magnitude = naive.gradient(code)
    np.testing.assert_allclose(magnitude, expected_magnitude, rtol=1e-6)
    assert naive.degrees_between(tangent, expected_tangent).max() < 1e-3


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    one, *others = each_thread_count(lambda: gradient(photo()))
    for other in others:
        np.testing.assert_array_equal(one.tangent, other.tangent)
        np.testing.assert_array_equal(one.magnitude, other.magnitude)


@pytest.mark.parametrize("reference", ["mean", "p101", "p-1", "p", "p99,5", "99.5", "P50", -1.0, np.nan, True, None])
def test_a_wrong_reference_names_itself_and_what_is_right(reference):
    with pytest.raises(ArgumentError, match="gradient_reference: expected") as error:
        measure_reference(np.zeros((3, 3)), reference)
    assert error.value.parameter == "gradient_reference"
    assert str(reference) in str(error.value)
