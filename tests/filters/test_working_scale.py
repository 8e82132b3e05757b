"""Which size "auto" chooses, and that filters give nearly the same there as at full size."""

import math

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.choices import WORKING_SCALES
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.working_scale import (
    PIXEL,
    evidence_factor,
    flow_factor,
    guidance_factor,
    lines_factor,
    regions_factor,
    shortened_blur,
    shortened_range,
    soft_edges_factor,
    step_across,
    step_along,
    step_of_smoothing,
    thin_lines_factor,
)

#: The shipped cartoon's lengths on a picture of 2160 lines.
ETF = {"radius": 20.0, "pre_blur": 4.0, "gradient_reference": 4.0, "fill": 1.0}
LINES = {"sigma_m": 12.0, "sigma_c": 4.0, "rho": 1.0, "color_weight": 0.5, "color_sign": True}
DRAWN = {**LINES, "iterations": 2, "pre_blur": 4.0, "contrast": 1.0, "softness": 4.0}
EVIDENT = {**DRAWN, "evidence": 0.5, "soft_lines": 0.7, "soft_reach": 28.0}
#: The same on a picture of 1080 lines: lines at full size, soft outlines and evidence at half of it.
PARTLY = {**DRAWN, "sigma_m": 6.0, "sigma_c": 2.0, "pre_blur": 2.1}
IN_PARTS = {"evidence": {"evidence": 1.0}, "soft outlines": {"soft_lines": 0.8, "soft_reach": 14.0}}
GUIDED = {"sigma_s": 8.0, "sigma_r": 15.0}
FBL = {"sigma_e": 8.0, "r_e": 15.0, "sigma_g": 8.0, "r_g": 10.0, "iterations": 3}


def drawn(height=270, width=360):
    """Return code values (H, W, 3): shapes with soft edges and a gradient, some grain, at 1:1 of a large plate."""
    y, x = np.mgrid[:height, :width].astype(np.float64)

    def within(distance):
        return 1 / (1 + np.exp(distance / 1.5))

    codes = np.stack([150 + x / 9, 4 + 0 * x, y / 20], -1)
    for centre_y, centre_x, radius, color in (
        (110, 130, 70, (80, 40, 20)),
        (125, 150, 30, (190, -20, 40)),
        (180, 270, 60, (60, 5, -45)),
    ):
        share = within(np.hypot(y - centre_y, x - centre_x) - radius)[..., None]
        codes = codes * (1 - share) + np.array(color) * share
    stroke = within(np.abs(0.4 * x - y + 150) - 5)[..., None]
    codes = codes * (1 - stroke) + np.array([30, 0, 0]) * stroke
    grain = np.random.default_rng(3).normal(0, 1.5, codes.shape)
    return (codes + grain).astype(np.float32)


@pytest.fixture(scope="module")
def picture():
    return drawn()


@pytest.fixture(scope="module")
def flow(picture):
    return filters.etf(picture, **ETF)


# ---------------------------------------------------------------------- the rule


@pytest.mark.parametrize(
    ("factor", "radius", "pre_blur"),
    [(1, 19.9, 8), (2, 20, 8), (2, 79.9, 8), (4, 80, 8), (1, 80, 0), (1, 80, 1.9), (2, 80, 2), (2, 80, 7.9)],
)
def test_auto_keeps_the_flows_lengths(factor, radius, pre_blur):
    assert flow_factor("auto", radius, pre_blur) == factor


@pytest.mark.parametrize(("factor", "sigma_c"), [(1, 1), (1, 3.9), (2, 4), (2, 15.9), (4, 16), (4, 100)])
def test_auto_keeps_the_width_of_lines(factor, sigma_c):
    assert lines_factor("auto", sigma_c) == factor


@pytest.mark.parametrize(
    ("factor", "sigma_c", "passes", "pre_blur"),
    [(1, 4, 2, 0), (2, 5.6, 2, 0), (2, 4, 2, 4), (1, 3.9, 2, 9), (2, 4, 1, 0), (2, 16, 3, 0), (4, 16, 3, 16)],
)
def test_auto_keeps_more_blur_for_several_passes(factor, sigma_c, passes, pre_blur):
    assert lines_factor("auto", sigma_c, passes, pre_blur) == factor


@pytest.mark.parametrize(("factor", "t"), [(1, 5.9), (2, 6), (2, 23.9), (4, 24)])
def test_auto_keeps_the_blur_of_the_picture_that_soft_edges_are_measured_in(factor, t):
    assert soft_edges_factor("auto", t) == factor


@pytest.mark.parametrize(
    ("factor", "sigma_c", "pre_blur"), [(1, 1, 1.5), (1, 2.7, 0), (2, 2, 2), (2, 2.8, 0), (2, 9, 6.5), (4, 11.2, 0)]
)
def test_auto_keeps_ink_wider_than_a_pixel_where_evidence_is_looked_for(factor, sigma_c, pre_blur):
    assert evidence_factor("auto", sigma_c, pre_blur) == factor


@pytest.mark.parametrize(
    ("factor", "width", "sigma_c", "pre_blur"),
    [(1, 6.9, 2, 3.4), (2, 7, 2, 3.4), (2, 16, 4, 6.8), (4, 28, 7, 9), (1, 20, 2.7, 0), (2, 20, 5.5, 0)],
)
def test_auto_keeps_thin_bright_lines_wide_enough(factor, width, sigma_c, pre_blur):
    assert thin_lines_factor("auto", width, sigma_c, pre_blur) == factor


@pytest.mark.parametrize(("smooth", "step"), [(2.9, 1), (3, 2)])
def test_the_last_blur_skips_pixels_where_it_is_long_unless_full(smooth, step):
    assert step_of_smoothing("auto", smooth) == step_of_smoothing("1/2", smooth) == step
    assert step_of_smoothing("full", smooth) == 1


@pytest.mark.parametrize(
    ("step", "sigma_m", "pre_blur"), [(1, 6, 2.1), (2, 6, 2.2), (2, 6, 3.2), (3, 6, 3.4), (3, 12, 6.8), (2, 4, 3.4)]
)
def test_samples_along_the_flow_are_no_farther_apart_than_blurs_are_long_unless_full(step, sigma_m, pre_blur):
    assert step_along("auto", sigma_m, pre_blur) == step_along("1/4", sigma_m, pre_blur) == step
    assert step_along("full", sigma_m, pre_blur) == 1


@pytest.mark.parametrize(("step", "sigma_c", "pre_blur"), [(1, 2, 2.1), (1, 1.7, 3.4), (2, 1.8, 2.2), (2, 9, 9)])
def test_so_are_those_across_it(step, sigma_c, pre_blur):
    assert step_across("auto", sigma_c, pre_blur) == step_across("1/2", sigma_c, pre_blur) == step
    assert step_across("full", sigma_c, pre_blur) == 1


@pytest.mark.parametrize(
    ("factor", "sigma_e", "sigma_g"),
    [(1, 7.9, 8), (1, 8, 3.9), (2, 8, 4), (2, 31.9, 16), (4, 32, 16), (2, 0, 4), (4, 32, 0), (1, 3, 0)],
)
def test_auto_keeps_the_sigmas_of_passes_that_run(factor, sigma_e, sigma_g):
    assert regions_factor("auto", sigma_e, sigma_g) == factor


@pytest.mark.parametrize(("word", "factor"), [("full", 1), ("1/2", 2), ("1/4", 4)])
def test_words_say_the_factor_whatever_the_lengths(word, factor):
    assert flow_factor(word, 3, 0) == lines_factor(word, 0.5) == regions_factor(word, 1, 1) == factor
    assert soft_edges_factor(word, 1) == evidence_factor(word, 0.5, 0) == factor
    assert thin_lines_factor(word, 4, 1, 0) == factor


def test_another_word_is_refused_with_the_nearest():
    with pytest.raises(ArgumentError, match="working_scale: expected one of 'full', 'auto', '1/2', '1/4', found 'ful'"):
        filters.etf(np.zeros((4, 4)), working_scale="ful")


def test_what_sampling_blurs_is_counted_in():
    assert shortened_blur(4, 2, 0) == 2
    assert math.isclose(4 * (shortened_blur(4, 2, PIXEL) ** 2 + PIXEL), 4**2 + PIXEL)
    assert shortened_blur(0, 2, PIXEL) == 0
    assert shortened_blur(0.2, 2, PIXEL) == 0.05  # a blur of its own that is larger than that: half of the half
    assert shortened_blur(4.1, 1, PIXEL) == 4.1
    assert [guidance_factor("auto", sigma_s) for sigma_s in (7.9, 8, 31.9, 32)] == [1, 2, 2, 4]
    assert math.isclose(shortened_range(10, 2), 9, rel_tol=0.01)


# ---------------------------------------------------------------------- the filters


def results(picture, flow, scale):
    lines, response = filters.fdog_iterative(picture, flow, **DRAWN, working_scale=scale)
    return {
        "flow": filters.etf(picture, **ETF, working_scale=scale),
        "fdog": filters.fdog(picture, flow, **LINES, working_scale=scale),
        "lines": lines,
        "response": response,
        "evident lines": filters.fdog_iterative(picture, flow, **EVIDENT, working_scale=scale)[0],
        "rolling guidance": filters.rolling_guidance(picture, **GUIDED, working_scale=scale),
        "fbl": filters.fbl(picture, flow, **FBL, working_scale=scale),
    }


@pytest.fixture(scope="module")
def full(picture, flow):
    return results(picture, flow, "full")


@pytest.fixture(scope="module")
def auto(picture, flow):
    return results(picture, flow, "auto")


def test_auto_is_half_the_size_here(picture, flow, full, auto):
    half = results(picture, flow, "1/2")
    for name in full:
        np.testing.assert_array_equal(auto[name], half[name])
        assert not np.array_equal(auto[name], full[name])


def test_lines_are_those_of_the_full_size(full, auto):
    for name, most in (("lines", 0.03), ("evident lines", 0.04)):
        ink = (1 - full[name]).mean()
        assert np.abs(auto[name] - full[name]).mean() <= most * ink
    assert np.sqrt(np.mean((auto["fdog"] - full["fdog"]) ** 2)) <= 0.04 * full["fdog"].std()


@pytest.mark.parametrize("part", IN_PARTS)
def test_what_works_smaller_than_the_lines_draws_those_of_the_full_size(picture, flow, part):
    params = {**PARTLY, **IN_PARTS[part]}
    auto, full = (filters.fdog_iterative(picture, flow, **params, working_scale=each)[0] for each in ("auto", "full"))
    without = filters.fdog_iterative(picture, flow, **PARTLY, working_scale="auto")[0]
    np.testing.assert_array_equal(without, filters.fdog_iterative(picture, flow, **PARTLY)[0])
    ink = (1 - full).mean()
    assert 0 < np.abs(auto - full).mean() <= 0.02 * ink
    assert np.abs(auto - full).mean() <= 0.5 * np.abs(without - full).mean(), "beside what the part does"


@pytest.mark.parametrize("pre_blur", [2.2, 3.4])
def test_some_samples_of_what_was_blurred_draw_the_same_lines(picture, flow, pre_blur):
    params = {**PARTLY, "pre_blur": pre_blur}
    auto, full = (filters.fdog_iterative(picture, flow, **params, working_scale=each)[0] for each in ("auto", "full"))
    assert 0 < np.abs(auto - full).mean() <= 0.004 * (1 - full).mean()


def test_evidence_at_half_the_size_leaves_a_long_line_as_it_is():
    y = np.mgrid[:60, :80][0]
    code = (200 - 150 * np.exp(-(((y - 30.2) / 3) ** 2) / 2)).astype(np.float32)
    flow = np.zeros((*code.shape, 2), np.float32)
    flow[..., 0] = 1
    params = {"sigma_m": 6.0, "sigma_c": 3.0, "rho": 1.0}
    kept = filters.fdog(code, flow, **params, evidence=1.0, working_scale="auto")
    np.testing.assert_allclose(kept, filters.fdog(code, flow, **params), rtol=1e-5, atol=1e-4)


def test_flats_are_those_of_the_full_size(full, auto):
    for name in ("fbl", "rolling guidance"):
        difference = np.abs(auto[name] - full[name])
        assert difference.mean() <= 1
        assert np.percentile(difference, 99) <= 12


def test_the_flow_is_that_of_the_full_size_where_there_are_edges(full, auto, picture):
    blurred = filters.blur(picture[..., 0], 4)
    edges = np.hypot(*np.gradient(blurred)) > 1
    cosine = np.abs((full["flow"] * auto["flow"]).sum(-1))[edges]
    assert np.degrees(np.arccos(np.minimum(np.percentile(cosine, 5), 1))) <= 3


@pytest.mark.parametrize("scale", ["1/2", "1/4"])
@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (7, 1), (5, 18), (33, 35)])
def test_any_size_of_picture(shape, scale):
    codes = np.random.default_rng(1).uniform(0, 255, (*shape, 3)).astype(np.float32)
    flow = filters.etf(codes, working_scale=scale)
    np.testing.assert_allclose(np.linalg.norm(flow, axis=-1), 1, atol=1e-6)
    alpha = np.random.default_rng(2).uniform(0, 1, shape).round(1)
    for result in (
        filters.fdog(codes, flow, color_weight=0.5, working_scale=scale),
        *filters.fdog_iterative(codes[..., 0], flow, form="xdog", pre_blur=1, working_scale=scale),
        filters.fbl(codes, flow, working_scale=scale),
        filters.fbl(codes, flow, alpha=alpha, working_scale=scale),
    ):
        assert result.shape[:2] == shape
        assert np.isfinite(result).all()


@pytest.mark.parametrize("scale", WORKING_SCALES)
def test_a_constant_picture_has_one_flow_no_lines_and_stays_what_it_is(scale):
    codes = np.full((37, 50, 3), np.float32(0.1))
    flow = filters.etf(codes, **ETF, working_scale=scale)
    assert (flow == [1, 0]).all()
    lines, response = filters.fdog_iterative(codes, flow, **DRAWN, working_scale=scale)
    assert (lines == 1).all()
    np.testing.assert_allclose(response, 0, atol=1e-6)
    np.testing.assert_array_equal(filters.fbl(codes, flow, **FBL, working_scale=scale), codes)
    np.testing.assert_array_equal(filters.rolling_guidance(codes, **GUIDED, working_scale=scale), codes)


@pytest.mark.parametrize("axis", [0, 1])
def test_flipped_pictures_give_flipped_results(picture, auto, axis):
    codes = picture[:268]  # whole blocks
    flow = filters.etf(codes, **ETF)
    flipped_flow = np.ascontiguousarray(np.flip(flow, axis)) * np.float32([1, -1])
    smooth = filters.fbl(codes, flow, **FBL, working_scale="1/2")
    flipped = filters.fbl(np.ascontiguousarray(np.flip(codes, axis)), flipped_flow, **FBL, working_scale="1/2")
    assert np.abs(np.flip(flipped, axis) - smooth).mean() < 0.02  # samples half between two pixels round to one side


def test_pixels_without_alpha_stay_and_never_show(picture, flow):
    alpha = np.ones(picture.shape[:2], np.float32)
    alpha[:, 181:] = 0
    poisoned = np.where(alpha[..., None] > 0, picture, np.float32(1e6))
    found = filters.fbl(poisoned, flow, **FBL, alpha=alpha, working_scale="1/2")
    other = filters.fbl(picture, flow, **FBL, alpha=alpha, working_scale="1/2")
    np.testing.assert_array_equal(found[:, :181], other[:, :181])
    np.testing.assert_array_equal(found[:, 181:], poisoned[:, 181:])


def test_any_number_of_threads_gives_the_same_bits(picture, flow, each_thread_count):
    for found in zip(
        *(each.values() for each in each_thread_count(lambda: results(picture, flow, "1/2"))), strict=True
    ):
        for other in found[1:]:
            np.testing.assert_array_equal(other, found[0])
