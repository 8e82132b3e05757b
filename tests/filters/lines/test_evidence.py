import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative, flow_blur, halo
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import fdog as naive

COLOR = {"rho": 1.0, "color_weight": 0.5, "color_sign": True}


@pytest.mark.parametrize("evidence", [0.3, 0.5, 1.0])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_definition_in_float64(name, evidence):
    image, flow = cases()[name]
    for code, options in ((image[..., 0], {"sigma_m": 2.0}), (image, COLOR)):
        response = fdog(code, flow, evidence=evidence, **options)
        assert response.dtype == np.float32
        expected = naive.fdog(code, flow, evidence=evidence, **options)
        np.testing.assert_allclose(response, expected, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(1).uniform(0, 255, shape).astype(np.float32)
    flow = random_flow(shape, 2)
    expected = naive.fdog(code, flow, evidence=1.0)
    np.testing.assert_allclose(fdog(code, flow, evidence=1.0), expected, rtol=1e-4, atol=1e-3)


def test_in_the_last_pass():
    image, flow = cases()["photo"]
    options = {**COLOR, "contrast": 1.5, "softness": 4.0, "iterations": 2, "pre_blur": 0.8, "evidence": 0.6}
    lines, response = fdog_iterative(image, flow, **options)
    expected_lines, expected = naive.fdog_iterative(image, flow, **options)
    np.testing.assert_allclose(response, expected, rtol=1e-4, atol=2e-3)
    np.testing.assert_allclose(lines, expected_lines, rtol=0, atol=1e-3)


def test_full_evidence_is_the_geometric_mean_with_the_longer_stretch():
    image, flow = cases()["photo"]
    h = fdog(image[..., 0], flow)
    n = np.maximum(-h, 0)
    b = flow_blur(n, flow, 9.0, "nearest")
    expected = np.where(h < 0, -np.minimum(n, np.sqrt(n * b)), h)
    np.testing.assert_allclose(fdog(image[..., 0], flow, evidence=1.0), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["photo", "noise"])
def test_it_only_weakens_what_is_below_0_the_more_the_higher(name):
    image, flow = cases()[name]
    plain, some, full = (fdog(image[..., 0], flow, evidence=e) for e in (0.0, 0.5, 1.0))
    np.testing.assert_array_equal(plain, fdog(image[..., 0], flow))
    above = plain >= 0
    np.testing.assert_array_equal(full[above], plain[above])
    assert (plain <= some).all()
    assert (some <= full).all()
    assert (full[~above] < 0).all()
    assert (full - plain).max() > 1


def upright(height, width):
    flow = np.zeros((height, width, 2), np.float32)
    flow[..., 1] = 1
    return flow


def test_a_speck_fades_and_a_long_line_of_the_same_strength_stays():
    code = np.full((120, 80), 200.0)
    code[:, 20] = 140
    code[58:62, 60] = 20  # answers at its middle as the line does
    plain, kept = (fdog(code, upright(120, 80), rho=1.0, evidence=e)[60] for e in (0.0, 1.0))
    assert 0.8 < plain[60] / plain[20] < 2
    assert kept[20] == pytest.approx(plain[20], rel=1e-3)
    assert kept[60] / plain[60] < 0.65


def test_along_a_tangent_of_zero_length_nothing_is_missing():
    image, _ = cases()["photo"]
    none = np.zeros((*image.shape[:2], 2), np.float32)
    for e in (0.5, 1.0):
        h = fdog(image[..., 0], none, evidence=e)
        np.testing.assert_allclose(h, fdog(image[..., 0], none), rtol=1e-5, atol=1e-5)


def test_a_constant_picture_has_no_ink():
    code = np.full((40, 60, 3), 90.0)
    flow = random_flow((40, 60), 3)
    h = fdog(code, flow, evidence=1.0, **COLOR)
    np.testing.assert_allclose(h, 0, atol=1e-3)


def test_a_crop_with_its_halo_has_the_same_bits():
    image, flow = cases()["photo"]
    image, flow = np.tile(image, (2, 2, 1)), np.tile(flow, (2, 2, 1))
    around = halo.fdog(1.0, 0.8) + halo.evidence(1.0, 0.7)
    whole = fdog(image, flow, 1.0, 0.8, evidence=0.7, **COLOR)
    crop = fdog(image[9:109, 11:115], flow[9:109, 11:115], 1.0, 0.8, evidence=0.7, **COLOR)
    inside = slice(around, -around)
    np.testing.assert_array_equal(crop[inside, inside], whole[9:109, 11:115][inside, inside])


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: fdog(image, flow, evidence=0.8, **COLOR))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_specks_of_noise_become_fewer():
    code = 127 + 6 * np.random.default_rng(1).standard_normal((160, 240))
    flow = etf(code, fill=4.0)
    options = {"rho": 1.0, "contrast": 1.0, "softness": 4.0, "iterations": 2}
    plain, kept = (fdog_iterative(code, flow, evidence=e, **options)[0] for e in (0.0, 1.0))
    assert (1 - kept).sum() < 0.6 * (1 - plain).sum()


@pytest.mark.parametrize("form", [{}, {"form": "xdog"}])
def test_xdog_takes_no_evidence(form):
    image, flow = cases()["photo"]
    plain, kept = (fdog_iterative(image[..., 0], flow, evidence=e, **form)[1] for e in (0.0, 1.0))
    assert np.array_equal(plain, kept) == bool(form)


@pytest.mark.parametrize("evidence", [-0.1, 1.1, np.nan, True])
@pytest.mark.parametrize("filter", [fdog, fdog_iterative])
def test_errors_name_the_argument(filter, evidence):
    with pytest.raises(ArgumentError, match="evidence: expected a number") as error:
        filter(np.zeros((4, 5)), np.zeros((4, 5, 2)), evidence=evidence)
    assert error.value.parameter == "evidence"
