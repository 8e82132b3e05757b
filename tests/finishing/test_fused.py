"""The fused pass equals decode, quantise and composite one after the other."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import color, filters
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.finishing.finish import finish
from flowabs_nodes.finishing.fused import quantized
from flowabs_nodes.finishing.operations import Ink, Operation, Quantize

REC709 = color.space("lin_rec709")
SHAPE = (5, 21)
RANDOM = np.random.default_rng(11)
RGB = RANDOM.uniform(0, 1.5, (*SHAPE, 3)).astype(np.float32)
LINES = RANDOM.random(SHAPE, np.float32)
INK = Ink(LINES, (0.1, 0.2, 0.3), 0.7)


def under() -> np.ndarray:
    """Premultiplied RGBA with light where alpha is 0."""
    alpha = np.clip(RANDOM.uniform(-0.3, 1.3, (*SHAPE, 1)), 0, 1)
    return np.concatenate([RANDOM.random((*SHAPE, 3)) * np.where(alpha > 0, alpha, 0.5), alpha], 2).astype(np.float32)


def one_after_the_other(codes: Codes, operations: tuple[Operation, ...]) -> np.ndarray:
    pixels = codes.decode(REC709)
    for operation in operations:
        if isinstance(operation, Quantize):
            pixels = quantized(pixels, operation.levels, operation.softness, REC709)
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
        quantized(grey, 4, 0.0, REC709),
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
        quantized(rgb, 4, 0.0, REC709)
