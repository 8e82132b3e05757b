"""Thin bright lines get one line on their middle: against float64, and on drawn lines, gratings, edges and noise."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.special import ndtr

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative, halo
from flowabs_nodes.filters.lines.extrema_across import closing, opening
from flowabs_nodes.filters.lines.thin_lines import mirror
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import thin_lines as naive

#: Lines as graphs of photographs draw them.
DRAWN = {"rho": 1.0, "contrast": 0.55, "softness": 4.0, "iterations": 2, "pre_blur": 1.5, "evidence": 1.0}


@pytest.mark.parametrize("width", [1.3, 4.0, 9.0])
def test_equals_float64(width):
    image, flow = cases()["photo"]
    code = image[..., 0].copy()
    code[7] = code[:, 20] = code[:, 41] = 250  # thin, alone, and some of them along the flow
    for found, expected in ((opening, naive.opening), (closing, naive.closing)):
        np.testing.assert_allclose(found(code, flow, width), expected(code, flow, width), atol=1e-3)
    found, expected = mirror(code, flow, width), naive.mirror(code, flow, width)
    assert np.abs(expected).max() > 10
    assert np.median(np.abs(found - expected)) < 1e-3
    assert (np.abs(found - expected) < 5e-2).mean() > 0.99  # nearest samples may fall to the other side


def test_pictures_of_several_tiles():
    y, x = np.mgrid[:150, :291]
    angle = 0.2 + 0.1 * np.sin(y / 30)
    flow = np.stack([-np.sin(angle), np.cos(angle)], -1).astype(np.float32)
    code = sum(90.0 * (abs(x + 0.2 * y - place) < 1.5) for place in (70, 150, 240)).astype(np.float32)
    np.testing.assert_allclose(opening(code, flow, 21.0), naive.opening(code, flow, 21.0), atol=1e-3)
    assert mirror(code, flow, 4.0).min() < -150


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(2).uniform(0, 255, shape).astype(np.float32)
    flow = random_flow(shape)
    np.testing.assert_allclose(opening(code, flow, 4.0), naive.opening(code, flow, 4.0), atol=1e-3)
    assert mirror(code, flow, 4.0).shape == shape


class Line:
    """A straight line at an angle; lengths are in pixels at ``scale`` 1."""

    def __init__(self, angle, scale=1):
        y, x = np.mgrid[-40 * scale : 40 * scale, -40 * scale : 40 * scale].astype(float)
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        self.scale, self.across, self.along = scale, (x * cos + y * sin) / scale, (y * cos - x * sin) / scale
        self.flow = np.broadcast_to(np.float32([-sin, cos]), (*x.shape, 2)).copy()

    def bar(self, width, contrast, blur=0.4, place=0.3):
        a = self.across - place
        return 120 + contrast * (ndtr((a + width / 2) / blur) - ndtr((a - width / 2) / blur))

    def draw(self, code, thin_lines=4.0, **given):
        s, given = self.scale, DRAWN | given
        lengths = {"sigma_m": 3.0 * s, "sigma_c": 1.0 * s, "thin_lines": thin_lines * s}
        lengths["pre_blur"] = given.pop("pre_blur") * s
        return fdog_iterative(code.astype(np.float32), self.flow, **lengths, **given)[0]

    def lines(self, drawing):
        """How many lines there are; the width, and the place across, of all ink."""
        inside = (abs(self.along) < 12) & (abs(self.across) < 20)
        ink, across = (1 - drawing)[inside], self.across[inside]
        bins = np.round(2 * across).astype(int)
        count = ndimage.label(ndimage.mean(ink, bins, np.unique(bins)) > 0.5)[1]
        return count, ink.sum() / (24 * self.scale**2), (ink * across).sum() / max(ink.sum(), 1e-9)


@pytest.mark.parametrize("width", [1.3, 2, 3])
@pytest.mark.parametrize(("angle", "scale"), [(0, 1), (27, 1), (61, 2)])
def test_a_bright_line_gets_the_one_line_of_a_dark_one_on_its_middle(angle, scale, width):
    line = Line(angle, scale)
    count, ink, place = line.lines(line.draw(line.bar(width, 80)))
    _, as_dark, _ = line.lines(line.draw(line.bar(width, -80)))
    assert count == 1
    assert ink == pytest.approx(as_dark, rel=0.2)
    assert place == pytest.approx(0.3, abs=0.25)
    assert line.lines(line.draw(line.bar(width, 80), thin_lines=0))[0] != 1


def test_in_one_pass_on_black_and_with_soft_lines():
    line = Line(27)
    cable = line.bar(2, 150) - 115  # 5 and 155: mirrored it is far below 0
    for given in ({"iterations": 1}, {"iterations": 2}, {"soft_lines": 1.0}, {"pre_blur": 0.0}):
        count, _, place = line.lines(line.draw(cable, **given))
        assert count == 1, given
        assert place == pytest.approx(0.3, abs=0.25), given


def test_a_wide_one_keeps_both():
    line = Line(27)
    np.testing.assert_array_equal(line.draw(line.bar(9, 80)), line.draw(line.bar(9, 80), thin_lines=0))


def test_dark_lines_edges_and_what_is_hardly_brighter_stay():
    line = Line(27)
    step = 100 + 60 * ndtr(line.across / 0.5)
    for code in (line.bar(2, -80), step, line.bar(2, 7)):
        assert abs(mirror(code.astype(np.float32), line.flow, 4.0)).max() < 0.2


def test_bright_lines_near_each_other_are_texture_and_stay():
    line = Line(27)
    grating = 120 + 40 * np.cos(2 * np.pi * line.across / 6)
    assert abs(mirror(grating.astype(np.float32), line.flow, 4.0)).max() < 1e-3


def test_noise_gets_no_more_ink():
    noise = 120 + 4 * np.random.default_rng(1).standard_normal((150, 200)).astype(np.float32)
    flow = etf(noise, pre_blur=1.0, gradient_reference=16.0, fill=4.0)
    assert abs(mirror(noise, flow, 4.0)).mean() < 0.01


def test_only_lightness_is_mirrored():
    line = Line(0)
    code = np.stack([np.full(line.across.shape, 120.0), line.bar(2, 80) - 120, 0 * line.across], -1)
    given = {"color_weight": 1.0, "color_sign": True}
    found, without = (line.draw(code, thin_lines=each, **given) for each in (4.0, 0.0))
    assert (1 - without).sum() > 10
    np.testing.assert_array_equal(found, without)


def test_of_tangents_only_the_direction_counts():
    image, flow = cases()["photo"]
    code = image[..., 0]
    for other in (-flow, 3 * flow):
        np.testing.assert_allclose(opening(code, other, 4.0), opening(code, flow, 4.0), atol=1e-3)


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    image, flow = cases()["photo"]
    tall, tall_flow = np.tile(image[..., 0], (3, 2)), np.tile(flow, (3, 2, 1))
    one, *others = each_thread_count(lambda: fdog_iterative(tall, tall_flow, softness=2.0, thin_lines=4.0)[0])
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("iterations", [1, 2])
def test_a_crop_with_its_halo_gives_the_same_bits(iterations):
    image, flow = cases()["photo"]
    wide, wide_flow = np.tile(image[..., 0], (2, 3)), np.tile(flow, (2, 3, 1))
    given = {"sigma_m": 1.5, "sigma_c": 0.8, "iterations": iterations, "pre_blur": 0.7}
    more = {"thin_lines": 3.0, "softness": 4.0, "contrast": 0.5}
    reach = halo.fdog_iterative(**given, thin_lines=3.0)
    left, right = 90 - reach, 100 + reach
    whole = fdog_iterative(wide, wide_flow, **given, **more)[0]
    assert (whole != fdog_iterative(wide, wide_flow, **given, **more | {"thin_lines": 0.0})[0]).any()
    crop = fdog_iterative(wide[:, left:right].copy(), wide_flow[:, left:right].copy(), **given, **more)[0]
    np.testing.assert_array_equal(crop[:, reach:-reach], whole[:, 90:100])


@pytest.mark.parametrize("value", [-1, True, float("nan"), 20_000])
@pytest.mark.parametrize("function", [fdog, fdog_iterative])
def test_errors_name_the_argument(function, value):
    with pytest.raises(ArgumentError, match="thin_lines") as error:
        function(np.zeros((4, 5)), np.zeros((4, 5, 2)), thin_lines=value)
    assert error.value.parameter == "thin_lines"
