"""Soft outlines get the line of sharp ones: against float64, and on drawn edges, lines, rings and noise."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.special import ndtr

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative, halo, threshold
from flowabs_nodes.filters.flow.flow_resolution import Flows
from flowabs_nodes.filters.lines.soft_edges import SoftEdges
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import fdog as naive
from tests.naive import soft_edges as naive_soft

#: Lines as graphs of photographs draw them.
DRAWN = {"rho": 1.0, "contrast": 0.65, "softness": 4.0, "iterations": 2, "pre_blur": 1.5}


def missing(code, flow, reach=7.0, **given):
    """What soft edges lack, and the same in float64, (H, W, C) both."""
    given = {"sigma_c": 1.0, "rho": 0.99, "color_weight": 0.0, "pre_blur": 0.0} | given
    planes = np.ascontiguousarray(np.moveaxis(np.atleast_3d(code), -1, 0))
    found = SoftEdges.checked(1.0, reach, **given).missing(planes, Flows(flow))
    expected = naive_soft.missing(np.atleast_3d(code), flow, reach, **given)
    return np.moveaxis(found, 0, -1), expected


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"reach": 3.0, "rho": 1.0, "pre_blur": 1.5},
        {"reach": 13.0, "sigma_c": 2.2, "pre_blur": 1.0},
        {"color_weight": 0.5, "pre_blur": 1.5},
    ],
)
def test_equals_the_edge_model_in_float64(given):
    image, flow = cases()["photo"]
    code = image if given.get("color_weight") else image[..., :1]
    found, expected = missing(code, flow, **given)
    assert np.abs(expected).max() > 1
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)


def test_pictures_of_several_tiles():
    y, x = np.mgrid[:150, :291]
    angle = 0.2 + 0.1 * np.sin(y / 30)
    flow = np.stack([-np.sin(angle), np.cos(angle)], -1).astype(np.float32)
    code = sum(60 * ndtr((x + 0.2 * y - place) / blur) for place, blur in ((70, 2), (150, 4), (240, 6))).astype(
        np.float32
    )
    found, expected = missing(code, flow)
    assert np.abs(expected).max() > 2
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(2).uniform(0, 255, shape).astype(np.float32)
    found, expected = missing(code, random_flow(shape))
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)


class Edge:
    """A straight edge, drawn at an angle: lengths are in pixels at ``scale`` 1."""

    def __init__(self, angle, scale=1):
        y, x = np.mgrid[-40 * scale : 40 * scale, -40 * scale : 40 * scale].astype(float)
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        self.scale, self.across, self.along = scale, (x * cos + y * sin) / scale, (y * cos - x * sin) / scale
        self.flow = np.broadcast_to(np.float32([-sin, cos]), (*x.shape, 2)).copy()

    def draw(self, code, **given):
        s, given = self.scale, DRAWN | {"soft_lines": 1.0} | given
        lengths = {"sigma_m": 3.0 * s, "sigma_c": s, "soft_reach": 7.0 * s, "pre_blur": given.pop("pre_blur") * s}
        return fdog_iterative(code.astype(np.float32), self.flow, **lengths, **given)[0]

    def step(self, blur, contrast):
        return 100 + contrast * ndtr((self.across - 0.3) / blur)

    def line(self, lines):
        """How many lines there are; the width, and the place across, of all ink."""
        inside = (abs(self.along) < 12) & (abs(self.across) < 20)
        ink, across = (1 - lines)[inside], self.across[inside]
        bins = np.round(2 * across).astype(int)
        count = ndimage.label(ndimage.mean(ink, bins, np.unique(bins)) > 0.5)[1]
        return count, ink.sum() / (24 * self.scale**2), (ink * across).sum() / max(ink.sum(), 1e-9)


@pytest.mark.parametrize("contrast", [40, 60, 80])
@pytest.mark.parametrize(("angle", "scale"), [(0, 1), (27, 1), (61, 2)])
def test_an_edge_of_any_blur_gets_one_line_as_wide_as_a_sharp_one_s_and_in_its_place(contrast, angle, scale):
    edge = Edge(angle, scale)
    _, sharp_width, sharp_place = edge.line(edge.draw(edge.step(0.01, contrast)))
    for blur in (0.5, 1, 2, 3, 4, 5, 6):
        count, width, place = edge.line(edge.draw(edge.step(blur, contrast)))
        assert count == 1, blur
        assert width == pytest.approx(sharp_width, rel=0.2), blur
        assert place == pytest.approx(sharp_place, abs=0.5), blur


def test_without_soft_lines_it_fades():
    edge = Edge(27)
    assert edge.line(edge.draw(edge.step(4, 80), soft_lines=0))[0] == 0
    half, whole = (edge.line(edge.draw(edge.step(4, 80), soft_lines=amount))[1] for amount in (0.5, 1))
    assert 0 < half < 0.9 * whole


def test_in_one_pass_and_without_a_blur_before():
    edge = Edge(27)

    def line(blur):
        response = fdog(edge.step(blur, 60).astype(np.float32), edge.flow, rho=1.0, soft_lines=1.0)
        return edge.line(threshold(response, contrast=0.65, softness=4.0))

    assert [line(blur)[0] for blur in (0.5, 2, 4, 6)] == [1, 1, 1, 1]
    assert line(4)[1] == pytest.approx(line(0.01)[1], rel=0.2)


@pytest.mark.parametrize(("blur", "contrast"), [(6, 80), (12, 800), (6, 15)])
def test_edges_that_are_softer_than_the_reach_or_that_noise_would_move_are_left_alone(blur, contrast):
    edge = Edge(0)
    soft = SoftEdges.checked(1.0, 7.0, sigma_c=1.0, rho=1.0, color_weight=0.0, pre_blur=1.5)
    found = abs(soft.missing(edge.step(blur, contrast).astype(np.float32)[None], Flows(edge.flow))[0, :, 20:60]).max()
    assert found > 3 if (blur, contrast) == (6, 80) else found < 0.01


@pytest.mark.parametrize("blur", [1, 2, 3, 3.5])
@pytest.mark.parametrize("contrast", [-60, 60])
def test_a_thin_line_stays_what_it_is(blur, contrast):
    edge = Edge(27)
    code = 128 + contrast * np.exp(-(edge.across**2) / (2 * blur**2))
    with_soft, without = (edge.line(edge.draw(code, soft_lines=amount)) for amount in (1, 0))
    assert with_soft[0] == without[0]
    assert with_soft[1] == pytest.approx(without[1], abs=0.5)
    if contrast < 0:
        assert with_soft[0] == 1


def test_white_noise_gets_no_more_ink():
    noise = 120 + 20 * np.random.default_rng(1).standard_normal((150, 200)).astype(np.float32)
    flow = etf(noise, pre_blur=1.0, gradient_reference=16.0, fill=4.0)
    given = DRAWN | {"contrast": 0.2, "pre_blur": 1.0}
    ink = [(1 - fdog_iterative(noise, flow, **given, soft_lines=amount)[0]).sum() for amount in (0, 1)]
    assert ink[0] > 1000
    assert ink[1] == pytest.approx(ink[0], rel=0.01)


def test_texture_gets_hardly_more_ink():
    chance = np.random.default_rng(3).standard_normal((150, 200))
    texture = (120 + 60 * ndimage.gaussian_filter(chance, 1.0)).astype(np.float32)  # grains of about a line's width
    flow = etf(texture, pre_blur=1.0, gradient_reference=16.0, fill=4.0)
    ink = [(1 - fdog_iterative(texture, flow, **DRAWN, soft_lines=amount)[0]).sum() for amount in (0, 1)]
    assert ink[0] > 1000
    assert ink[1] == pytest.approx(ink[0], rel=0.03)


def ring_of_ink(radius, blur):
    """How much ink the outline of a soft disc gets beside none, along its whole outline and a pixel wide."""
    y, x = np.mgrid[-60:61, -60:61].astype(float)
    distance = np.maximum(np.hypot(x, y), 1e-9)
    flow = np.stack([-y / distance, x / distance], -1).astype(np.float32)
    disc = 60 + 90 * ndimage.gaussian_filter((distance < radius).astype(float), blur)
    ink = [1 - fdog_iterative(disc.astype(np.float32), flow, **DRAWN, soft_lines=amount)[0] for amount in (0, 1)]
    return (ink[1] - ink[0]).sum() / (2 * np.pi * radius)


def test_a_disc_gets_an_outline_and_a_blob_hardly_larger_than_its_blur_none():
    assert ring_of_ink(40, 3) > 2
    assert ring_of_ink(10, 3) < 0.2


def test_colours_count_as_in_the_response():
    edge = Edge(0)
    grey, red = np.full(edge.across.shape, 120.0), edge.step(4, 80) - 100
    code = np.stack([grey, red, 0 * grey], -1)
    given = {"color_sign": True, "contrast": 0.65}
    blind, soft = (edge.line(edge.draw(code, color_weight=weight, **given)) for weight in (0, 0.5))
    code[..., 1] = edge.step(0.01, 80) - 100
    assert blind[:2] == (0, 0)
    assert soft[1] == pytest.approx(edge.line(edge.draw(code, color_weight=0.5, **given))[1], rel=0.2)


def test_the_sign_and_the_length_of_tangents_have_no_meaning():
    image, flow = cases()["photo"]
    found = missing(image, flow, color_weight=0.5)[0]
    np.testing.assert_allclose(missing(image, -flow, color_weight=0.5)[0], found, atol=1e-3)


def test_mirrored_pictures_give_mirrored_lines():
    image, flow = cases()["photo"]
    turned = flow[:, ::-1] * np.float32([-1, 1])
    found = fdog(image[..., 0], flow, soft_lines=1.0)
    np.testing.assert_allclose(fdog(image[:, ::-1, 0], turned, soft_lines=1.0)[:, ::-1], found, atol=2e-2)


@pytest.mark.parametrize("kernel", ["separable", "full"])
@pytest.mark.parametrize("sampling", ["bilinear", "nearest"])
def test_what_is_missing_is_added_before_the_sum_along_the_flow(kernel, sampling):
    image, flow = cases()["photo"]
    options = {"rho": 0.98, "color_weight": 0.5, "kernel": kernel, "sampling": sampling}
    lack = naive_soft.missing(image, flow, 5.0, 0.7, rho=0.98, color_weight=0.5)
    expected = naive.fdog(image, flow, **options, missing=lack)
    found = fdog(image, flow, **options, soft_lines=0.7, soft_reach=5.0)
    assert np.median(abs(found - expected)) < 1e-3
    assert (abs(found - expected) < 2e-2).mean() > 0.99


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, flow = cases()["photo"]
    tall, tall_flow = np.tile(image, (3, 2, 1)), np.tile(flow, (3, 2, 1))
    one, *others = each_thread_count(
        lambda: fdog_iterative(tall, tall_flow, color_weight=0.5, softness=2.0, pre_blur=1.0, soft_lines=1.0)[0]
    )
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("iterations", [1, 2])
def test_a_crop_with_its_halo_gives_the_same_bits(iterations):
    image, flow = cases()["photo"]
    wide, wide_flow = np.tile(image, (2, 3, 1)), np.tile(flow, (2, 3, 1))
    given = {"sigma_m": 2.0, "sigma_c": 0.8, "iterations": iterations, "pre_blur": 0.7}
    more = {"soft_lines": 1.0, "soft_reach": 4.0, "color_weight": 0.5, "softness": 4.0, "contrast": 0.5}
    reach = halo.fdog_iterative(**given, soft_reach=4.0)
    left, right = 90 - reach, 100 + reach
    whole = fdog_iterative(wide, wide_flow, **given, **more)[0]
    crop = fdog_iterative(wide[:, left:right].copy(), wide_flow[:, left:right].copy(), **given, **more)[0]
    np.testing.assert_array_equal(crop[:, reach:-reach], whole[:, 90:100])


def test_zero_changes_nothing_whatever_the_reach():
    image, flow = cases()["photo"]
    np.testing.assert_array_equal(fdog(image, flow, soft_lines=0, soft_reach=99.0), fdog(image, flow))


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"soft_lines": -0.1}, "soft_lines"),
        ({"soft_lines": 1.5}, "soft_lines"),
        ({"soft_lines": True}, "soft_lines"),
        ({"soft_reach": 0.5}, "soft_reach"),
        ({"soft_reach": float("nan")}, "soft_reach"),
    ],
)
@pytest.mark.parametrize("function", [fdog, fdog_iterative])
def test_errors_name_the_argument(function, arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        function(np.zeros((4, 5)), np.zeros((4, 5, 2)), **arguments)
    assert error.value.parameter == parameter
