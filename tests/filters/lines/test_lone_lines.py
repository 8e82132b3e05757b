import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative, halo
from tests.filters.flows import THIN, cases, random_flow
from tests.filters.lines.test_evidence import COLOR, upright
from tests.naive import fdog as naive


@pytest.mark.parametrize("options", [{"lone_lines": 6.0}, {"lone_lines": 3.0, "evidence": 1.0}])
@pytest.mark.parametrize("name", ["photo", "noise"])
def test_equals_the_definition_in_float64(name, options):
    image, flow = cases()[name]
    response = fdog(image, flow, **COLOR, **options)
    assert response.dtype == np.float32
    np.testing.assert_allclose(response, naive.fdog(image, flow, **COLOR, **options), rtol=1e-4, atol=2e-3)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(1).uniform(0, 255, shape).astype(np.float32)
    flow = random_flow(shape, 2)
    expected = naive.fdog(code, flow, lone_lines=5.0)
    np.testing.assert_allclose(fdog(code, flow, lone_lines=5.0), expected, rtol=1e-4, atol=1e-3)


def test_in_the_last_pass():
    image, flow = cases()["photo"]
    options = {**COLOR, "contrast": 1.5, "softness": 4.0, "iterations": 2, "evidence": 0.6, "lone_lines": 6.0}
    _, response = fdog_iterative(image, flow, **options)
    np.testing.assert_allclose(response, naive.fdog_iterative(image, flow, **options)[1], rtol=1e-4, atol=2e-3)


def test_a_faint_line_that_is_alone_gains_what_one_of_many_does_not():
    code = np.full((160, 200), 200.0)
    code[:, 40] -= 2
    code[:, 120::5] -= 2
    plain, strengthened = (fdog(code, upright(160, 200), rho=1.0, lone_lines=each)[80] for each in (0.0, 6.0))
    assert 3 < strengthened[40] / plain[40] < 7
    assert 1 <= strengthened[155] / plain[155] < 1.4


def test_a_strong_line_needs_little():
    code = np.full((160, 81), 200.0)
    code[:, 40] -= 150
    plain, strengthened = (fdog(code, upright(160, 81), rho=1.0, lone_lines=each)[80, 40] for each in (0.0, 6.0))
    assert 1 < strengthened / plain < 1.4


def test_noise_gains_next_to_nothing():
    code = 127 + 2 * np.random.default_rng(1).standard_normal((160, 240))
    flow = etf(code, fill=4.0)
    plain, strengthened = (-np.minimum(fdog(code, flow, rho=1.0, lone_lines=each), 0) for each in (0.0, 6.0))
    assert strengthened.sum() < 1.1 * plain.sum()


def test_it_only_strengthens_what_is_below_0():
    image, flow = cases()["photo"]
    plain, strengthened = (fdog(image[..., 0], flow, lone_lines=each) for each in (0.0, 6.0))
    np.testing.assert_array_equal(strengthened[plain >= 0], plain[plain >= 0])
    assert (strengthened <= plain).all()


def test_a_crop_with_its_halo_has_the_same_bits():
    code = np.full((140, 150), 200.0)
    code[:, 70] -= 2
    code[:, ::40] -= 9
    around = halo.fdog(1.0, 0.8) + halo.evidence(1.0, 6.0)
    whole, crop = (fdog(each, upright(*each.shape), 1.0, 0.8, lone_lines=6.0) for each in (code, code[9:109, 11:115]))
    inside = slice(around, -around)
    np.testing.assert_array_equal(crop[inside, inside], whole[9:109, 11:115][inside, inside])


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, flow = cases()["noise"]
    one, *others = each_thread_count(lambda: fdog(image, flow, lone_lines=6.0, **COLOR))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_half_the_size_strengthens_as_much():
    code = np.full((240, 240), 200.0)
    code[:, 118:122] -= 3
    flow = upright(240, 240)
    full, half = (
        fdog(code, flow, 6.0, 4.0, rho=1.0, lone_lines=6.0, working_scale=scale)[120].min() for scale in ("full", "1/2")
    )
    assert half == pytest.approx(full, rel=0.1)


def test_xdog_strengthens_nothing():
    image, flow = cases()["photo"]
    plain, other = (fdog_iterative(image[..., 0], flow, lone_lines=each, form="xdog")[1] for each in (0.0, 6.0))
    np.testing.assert_array_equal(plain, other)


@pytest.mark.parametrize("value", [-0.1, 1001, np.nan, True])
@pytest.mark.parametrize("filter", [fdog, fdog_iterative])
def test_errors_name_the_argument(filter, value):
    with pytest.raises(ArgumentError, match="lone_lines: expected a number") as error:
        filter(np.zeros((4, 5)), np.zeros((4, 5, 2)), lone_lines=value)
    assert error.value.parameter == "lone_lines"
