"""The fused pass equals decode, quantise and composite one after the other."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import color, filters
from flowabs_nodes.color.codes import Codes, encoded
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.regions.rise import rise
from flowabs_nodes.finishing.finish import finish
from flowabs_nodes.finishing.fused import decoded, quantized
from flowabs_nodes.finishing.operations import Ink, Operation, Quantize
from tests.naive import quantize as naive

REC709 = color.space("lin_rec709")
SHAPE = (5, 21)
RANDOM = np.random.default_rng(11)
RGB = RANDOM.uniform(0, 1.5, (*SHAPE, 3)).astype(np.float32)
LINES = RANDOM.random(SHAPE, np.float32)
INK = Ink(LINES, (0.1, 0.2, 0.3), 0.7)
FIVE = Quantize(5, 0.5)
BY_GRADIENT = Quantize(5, 0.5, 0.3, 1.2, 0.9, 4.0, 6 * RANDOM.random(SHAPE, np.float32))


def under() -> np.ndarray:
    """Premultiplied RGBA with light where alpha is 0."""
    alpha = np.clip(RANDOM.uniform(-0.3, 1.3, (*SHAPE, 1)), 0, 1)
    return np.concatenate([RANDOM.random((*SHAPE, 3)) * np.where(alpha > 0, alpha, 0.5), alpha], 2).astype(np.float32)


def one_after_the_other(codes: Codes, operations: tuple[Operation, ...]) -> np.ndarray:
    pixels = codes.decode(REC709)
    for operation in operations:
        if isinstance(operation, Quantize):
            pixels = quantized(pixels, operation, REC709)
        else:
            alpha = pixels[..., 3] if pixels.shape[2] == 4 else None
            rgb = filters.composite(pixels[..., :3], operation.lines, operation.color, operation.opacity, alpha)
            pixels = np.concatenate([rgb, pixels[..., 3:]], 2)
    return pixels


@pytest.mark.parametrize("with_alpha", [False, True])
@pytest.mark.parametrize(
    ("space", "operations"),
    [
        ("lab", (Quantize(4, 0.0),)),
        ("lab", (Quantize(6, 0.5),)),
        ("lab", (INK,)),
        ("lab", (Quantize(4, 0.3), INK)),
        ("lab", (BY_GRADIENT, INK)),
        ("acescct", (INK,)),
    ],
)
def test_equals_the_steps_one_after_the_other(space: str, operations: tuple[Operation, ...], with_alpha: bool) -> None:
    codes = Codes(color.encode(RGB, space), space, under() if with_alpha else None)
    pixels = finish(codes, operations, REC709)
    assert pixels.dtype == np.float32
    assert pixels.shape == (*SHAPE, 4 if with_alpha else 3)
    np.testing.assert_allclose(pixels, one_after_the_other(codes, operations), rtol=2e-4, atol=2e-5)


def test_pixels_without_alpha_stay_what_they_were() -> None:
    below = under()
    below[1, 2] = (0.5, 0.25, 0.125, 0)
    codes = Codes(color.encode(RGB), "lab", below)
    np.testing.assert_array_equal(finish(codes, (INK,), REC709)[..., 3], below[..., 3])
    untouched = finish(codes, (Ink(np.ones(SHAPE, np.float32), (0, 0, 0), 1.0),), REC709)
    np.testing.assert_array_equal(untouched[1, 2], below[1, 2])


def test_quantised_greys() -> None:
    """Four levels are the L* 12.5, 37.5, 62.5 and 87.5."""
    lstar = np.array([[20, 30, 60, 90]], np.float32)
    grey = np.repeat(color.lstar_inverse(lstar)[..., None], 3, 2)
    expected = [[12.5, 37.5, 62.5, 87.5]]
    for pixels in (
        quantized(grey, Quantize(4, 0.0), REC709),
        finish(Codes(color.encode(grey), "lab"), (Quantize(4, 0.0),), REC709),
    ):
        np.testing.assert_allclose(color.lstar(color.luminance(pixels)), expected, atol=1e-3)


def test_full_ink_is_its_colour_and_paper_the_picture() -> None:
    codes = Codes(color.encode(RGB), "lab")
    ink, paper = (
        finish(codes, (Ink(np.full(SHAPE, value, np.float32), (0.1, 0.2, 0.3), 1.0),), REC709) for value in (0, 1)
    )
    np.testing.assert_allclose(ink, np.broadcast_to(np.float32([0.1, 0.2, 0.3]), RGB.shape), atol=1e-6)
    np.testing.assert_array_equal(paper, codes.decode(REC709))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("space", color.SPACES)
def test_code_values_that_are_not_finite_are_counted(space: str, bad: float) -> None:
    values = color.encode(RGB, space)
    values[2, 3, 1] = bad
    with pytest.raises(ArgumentError, match="found 1 that are NaN or Inf"):
        finish(Codes(values, space), (INK,), REC709)


def test_pixels_that_are_not_finite_are_counted() -> None:
    rgb = RGB.copy()
    rgb[0, :2, 0] = np.nan
    with pytest.raises(ArgumentError, match="found 2 that are NaN or Inf"):
        quantized(rgb, Quantize(4, 0.0), REC709)


@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("levels", [1, 4, 10, 16])
def test_the_gain_is_the_definition_s(levels: int, softness: float) -> None:
    lstar = np.linspace(-20, 130, 1501, dtype=np.float32)
    if softness == 0:
        lstar = lstar[np.abs(lstar * levels / 100 - 1e-3 - np.rint(lstar * levels / 100)) > 2e-3]  # not at a hard step
    rgb = color.lstar_inverse(lstar)[None, :, None] * np.float32([1.5, 0.9, 0.5])
    rgb /= color.luminance(np.float32([1.5, 0.9, 0.5]))
    expected = [naive.gain(float(value), levels, softness) for value in lstar]
    flat = quantized(rgb, Quantize(levels, softness), REC709)
    np.testing.assert_allclose(flat, rgb * np.array(expected)[None, :, None], rtol=1e-4, atol=1e-6)
    on_the_way = decoded(Codes(color.encode(rgb), "lab"), Quantize(levels, softness), None, REC709)
    np.testing.assert_allclose(on_the_way, flat, rtol=2e-4, atol=2e-6)


#: Pixels at or below zero luminance, of every origin that we know of.
LIGHTLESS = {
    "black": (0, 0, 0),
    "noise in blacks": (0.004, -0.006, 0.003),
    "noise far below": (-0.05, -0.04, -0.06),
    "a ringing resample": (-2.7, -2.7, -2.7),
    "a blue light outside the gamut": (-0.4, -0.15, 2.4),
    "a green that a matrix made": (-1.9, 0.4, -0.5),
    "enormous": (-1e30, -1e30, -1e30),
    "next to nothing": (-1e-40, -1e-42, 0),
}


@pytest.mark.parametrize("rgb", LIGHTLESS.values(), ids=LIGHTLESS)
@pytest.mark.parametrize("steps", [Quantize(1, 0.0), Quantize(8, 0.0), Quantize(10, 0.7), Quantize(1000, 1.0)])
def test_a_pixel_without_luminance_stays_what_it_is(rgb: tuple[float, ...], steps: Quantize) -> None:
    pixels = np.full((4, 9, 3), rgb, np.float32)
    np.testing.assert_array_equal(quantized(pixels, steps, REC709), pixels)
    codes = Codes(color.encode(pixels), "lab")
    np.testing.assert_array_equal(decoded(codes, steps, None, REC709), codes.decode(REC709))
    np.testing.assert_allclose(codes.decode(REC709), pixels, rtol=0, atol=3e-5 * np.abs(pixels).max() + 1e-37)
    half = decoded(codes, steps, Ink(np.full((4, 9), 0.5, np.float32), (0, 0, 0), 1.0), REC709)
    np.testing.assert_allclose(half, codes.decode(REC709) / 2, rtol=1e-6)


def test_light_outside_the_gamut_keeps_its_colour() -> None:
    """Its negative channels are scaled with the rest."""
    rgb = np.float32([[[-0.2, -0.1, 3], [-0.05, 0.9, -0.02], [1.4, -0.1, -0.05], [-4, 1.2, 30]]])
    flat = quantized(rgb, Quantize(6, 0.5), REC709)
    assert (color.luminance(rgb) > 0).all()
    np.testing.assert_allclose(flat / flat[..., 2:], rgb / rgb[..., 2:], rtol=1e-5)


@pytest.mark.parametrize("alpha", [0.0, -0.25, -3.0, 1e-45, 1e-38, 1e-20])
def test_pixels_that_are_not_covered_come_out_as_they_went_in(alpha: float) -> None:
    """Also where alpha is too small to divide by, and where it is negative."""
    below = np.full((3, 9, 4), (4.0, 0.18, -1.0, alpha), np.float32)
    below[1] = (0.5, 0.4, 0.3, 1)
    codes = Codes(encoded(below, "lab", REC709, mono=False)[0], "lab", below)
    for flat in (
        codes.decode(REC709),
        quantized(below, Quantize(4, 0.5), REC709),
        decoded(codes, Quantize(4, 0.5), None, REC709),
    ):
        np.testing.assert_array_equal(flat[[0, 2]], below[[0, 2]])
        np.testing.assert_array_equal(np.signbit(flat[[0, 2]]), np.signbit(below[[0, 2]]))
        assert (flat[1, :, 3] == 1).all()


@pytest.mark.parametrize(
    ("codes", "operations"),
    [
        ((3e38, 0, 0), ()),
        ((1e20, 0, 0), (Quantize(8, 0.5),)),
        ((100, 1e17, 0), (INK,)),
        ((100, 0, -1e30), (Quantize(8, 0.0), INK)),
        ((3e38, 3e38, -3e38), ()),
    ],
)
def test_code_values_beyond_light_are_refused(codes: tuple[float, ...], operations: tuple[Operation, ...]) -> None:
    values = color.encode(RGB)
    values[2, 3] = codes
    with pytest.raises(ArgumentError, match=r"codes: .* found larger ones in 1 pixels, the first .* at x 3, y 2"):
        finish(Codes(values, "lab"), operations, REC709)


@pytest.mark.parametrize("chroma", [0.0, 0.6, 1.3])
def test_chroma_is_a_gain_on_a_and_b(chroma: float) -> None:
    """From L* 8 up; colours at L* 1 and below stay. Pixels and code values are of one mind."""
    codes = RANDOM.uniform(-60, 60, (*SHAPE, 3)).astype(np.float32)
    codes[..., 0] = RANDOM.uniform(0.1, 250, SHAPE)
    rgb = color.decode(codes)
    lstar = codes[..., :1] / 2.55
    gain = 1 + (chroma - 1) * np.clip((lstar - 1) / 7, 0, 1)
    expected = quantized(color.decode(codes * np.concatenate([np.ones_like(gain), gain, gain], 2)), FIVE, REC709)
    with_chroma = FIVE._replace(chroma=chroma)
    np.testing.assert_allclose(quantized(rgb, with_chroma, REC709), expected, rtol=1e-4, atol=1e-4)
    np.testing.assert_allclose(decoded(Codes(codes, "lab"), with_chroma, None, REC709), expected, rtol=1e-4, atol=1e-4)
    dark = lstar[..., 0] <= 1
    np.testing.assert_array_equal(quantized(rgb, with_chroma, REC709)[dark], rgb[dark])


def test_no_chroma_is_grey_and_alpha_stays() -> None:
    below = under()
    grey = quantized(below, FIVE._replace(chroma=0.0), REC709)
    covered = below[..., 3] > 0
    light = color.lstar(color.luminance(grey[..., :3])) / np.where(covered, below[..., 3], 1) > 8
    np.testing.assert_allclose(grey[..., 0][covered & light], grey[..., 2][covered & light], rtol=1e-4)
    np.testing.assert_array_equal(grey[..., 3], below[..., 3])
    np.testing.assert_array_equal(grey[~covered], below[~covered])


def test_a_phase_moves_the_levels() -> None:
    """Half a bin up, four levels are the L* 6.25 (what is left of the first), 25, 50, 75 and 100."""
    grey = np.repeat(color.lstar_inverse(np.array([[11, 20, 60, 90]], np.float32))[..., None], 3, 2)
    flat = quantized(grey, Quantize(4, 0.0, phase=0.5), REC709)
    np.testing.assert_allclose(color.lstar(color.luminance(flat)), [[6.25, 25, 50, 100]], atol=1e-3)


@pytest.mark.parametrize("phase", [0.0, 0.4])
def test_the_gain_by_the_gradient_is_the_filter_s(phase: float) -> None:
    lstar = RANDOM.uniform(9, 120, SHAPE).astype(np.float32)
    rgb = np.repeat(color.lstar_inverse(lstar)[..., None], 3, 2)
    steps = Quantize(7, 0.3, phase, by_gradient=0.8, hard_gradient=20.0, rises=rise(lstar, 1.2))
    expected = filters.quantize(lstar, 7, 0.3, phase, 0.8, 1.2, 20.0)
    for flat in (quantized(rgb, steps, REC709), decoded(Codes(color.encode(rgb), "lab"), steps, None, REC709)):
        np.testing.assert_allclose(color.lstar(color.luminance(flat)), expected, atol=2e-2)
