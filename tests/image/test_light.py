"""How a host's numbers become an image's, and a host's again."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import ocio, srgb
from flowabs_nodes.errors import ColorError
from flowabs_nodes.image.light import decoded, encode_to
from flowabs_nodes.image.numbers import meaning
from flowabs_nodes.simd.bands import limited

RANDOM = np.random.default_rng(4)
REC709, AP1 = color.space("lin_rec709"), color.space("ACEScg")


def every_code(dtype: type, width: int = 256) -> np.ndarray:
    """Return a picture of codes (256, width, 4): 256 codes of red under each of 256 alphas, green against it."""
    code = np.arange(width)
    red, green, blue, alpha = np.broadcast_arrays(code, code[::-1], 7 * code % 256, np.arange(256)[:, None])
    scale = np.iinfo(dtype).max // 255
    return np.stack([red, green, blue, alpha], axis=2).astype(dtype) * dtype(scale)


def back(pixels: np.ndarray, like: np.ndarray, numbers: Any) -> np.ndarray:
    target = np.empty_like(like)
    encode_to(target, tuple(range(like.shape[2])), pixels, numbers.kept, numbers)
    return target


@pytest.mark.parametrize("alpha", ["straight", "premultiplied"])
@pytest.mark.parametrize("encoding", ["sRGB", "linear", "Rec.1886 Rec.709 - Display"])
def test_eight_bits_come_back_as_they_were_under_every_alpha(encoding: str, alpha: str) -> None:
    codes, numbers = every_code(np.uint8), meaning(None, encoding, alpha, floats=False)
    found = back(decoded(codes, numbers), codes, numbers)
    if alpha == "straight":  # times an alpha of 0: that colour is gone
        np.testing.assert_array_equal(found[0, :, :3], 0)
        np.testing.assert_array_equal(found[1:], codes[1:])
    else:
        np.testing.assert_array_equal(found, codes)


@pytest.mark.parametrize("alpha", ["straight", "premultiplied"])
def test_sixteen_bits_of_srgb_come_back_as_they_were(alpha: str) -> None:
    codes, numbers = every_code(np.uint16), meaning(None, "sRGB", alpha, floats=False)
    codes[..., 0] += np.arange(256, dtype=np.uint16) % 250
    codes[..., 0] = np.minimum(codes[..., 0], 65535)
    found = back(decoded(codes, numbers), codes, numbers)
    np.testing.assert_array_equal(found[1:], codes[1:])


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("count", [1, 3, 4])
def test_codes_that_are_looked_up_are_those_that_are_calculated(dtype: type, count: int) -> None:
    white = np.iinfo(dtype).max
    codes = np.arange(white + 1, dtype=dtype).reshape(-1, 64, 1).repeat(count, axis=2)
    found = decoded(codes, meaning(None, "sRGB", None, floats=False))
    light = srgb.linear(codes / np.float32(white))
    if count == 4:
        light[..., :3] *= codes[..., 3:] / np.float32(white)
        light[..., 3:] = codes[..., 3:] / np.float32(white)
    np.testing.assert_array_equal(found, light)


def test_premultiplied_codes_are_divided_by_alpha_before_they_are_decoded() -> None:
    straight = RANDOM.random((40, 30, 4), np.float32)
    straight[..., 3] = straight[..., 3].clip(0.1, 1)
    premultiplied = straight.copy()
    premultiplied[..., :3] *= straight[..., 3:]
    premultiplied[0, 0] = (0.5, 0.25, 0.125, 0)  # light without cover
    first = decoded(straight, meaning(None, "sRGB", "straight", floats=True))
    second = decoded(premultiplied, meaning(None, "sRGB", "premultiplied", floats=True))
    np.testing.assert_allclose(second[1:], first[1:], rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(second[0, 0], [*srgb.linear(premultiplied[0, 0, :3]), 0], rtol=1e-6)
    numbers = meaning(None, "sRGB", "premultiplied", floats=True)
    np.testing.assert_allclose(back(second, premultiplied, numbers), premultiplied, rtol=1e-5, atol=1e-6)


def test_light_in_another_space_is_converted_both_ways() -> None:
    rgba = RANDOM.random((8, 9, 4), np.float32)
    numbers = meaning("ACEScg", "lin_rec709", None, floats=True)
    found = decoded(rgba, numbers)
    expected = ocio.encode_named(rgba, REC709, "ACEScg")
    np.testing.assert_allclose(found, expected, atol=1e-6)
    target = np.empty_like(rgba)
    encode_to(target, (0, 1, 2, 3), found, AP1, meaning(None, "lin_rec709", None, floats=True))
    np.testing.assert_allclose(target, rgba, atol=1e-6)


@pytest.mark.parametrize("encoding", ["sRGB", "ACEScct", "linear"])
def test_bits_are_the_same_for_any_number_of_threads(encoding: str) -> None:
    codes = RANDOM.random((199, 301, 4), np.float32)
    numbers = meaning(None, encoding, "straight", floats=True)
    with limited(1):
        alone = decoded(codes, numbers)
        encoded_alone = back(alone, codes, numbers)
    with limited(5):
        together = decoded(codes, numbers)
        np.testing.assert_array_equal(together, alone)
        np.testing.assert_array_equal(back(together, codes, numbers), encoded_alone)


def test_an_overflow_is_said_with_its_place_in_the_whole_picture() -> None:
    codes = np.zeros((400, 90, 3), np.float32)
    codes[333, 44, 1] = 3e38
    with pytest.raises(ColorError, match=r"1 pixel becomes NaN or Inf, the first at x 44, y 333: 0 3e\+38 0"):
        decoded(codes, meaning(None, "sRGB", None, floats=True))


def test_nan_stays_in_floats_and_is_0_in_whole_numbers() -> None:
    codes = np.full((2, 2, 3), 0.5, np.float32)
    codes[0, 0, 0] = np.nan
    numbers = meaning(None, "sRGB", None, floats=True)
    pixels = decoded(codes, numbers)
    assert np.isnan(pixels).sum() == np.isnan(pixels[0, 0, 0]) == 1
    np.testing.assert_allclose(back(pixels, codes, numbers), codes, atol=1e-6)
    bytes_ = back(pixels, np.zeros(codes.shape, np.uint8), numbers)
    assert (bytes_[0, 0, 0], bytes_[0, 0, 1]) == (0, 128)


def test_whole_numbers_are_rounded_and_clipped() -> None:
    pixels = np.array([[[-1, 0.5 / 255 - 1e-6, 0.5 / 255 + 1e-6], [254.4 / 255, 1, 7]]], np.float32)
    target = np.empty((1, 2, 3), np.uint8)
    encode_to(target, (0, 1, 2), pixels, REC709, meaning(None, "linear", None, floats=False))
    assert target.ravel().tolist() == [0, 0, 1, 254, 255, 255]


def test_half_floats_end_at_their_largest_number() -> None:
    pixels = np.array([[[1e6, -1e6, np.inf], [np.nan, 0.5, 65504]]], np.float32)
    target = np.empty((1, 2, 3), np.float16)
    encode_to(target, (0, 1, 2), pixels, REC709, meaning(None, None, None, floats=True))
    np.testing.assert_array_equal(target.ravel(), [65504, -65504, np.inf, np.nan, 0.5, 65504])
