"""NaN and Inf are counted, and repaired from their neighbours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.nonfinite import count, repaired, said
from flowabs_nodes.io.read import read_image
from tests.io.files import colors, exr, planes


def test_clean_pixels_are_handed_back() -> None:
    pixels = np.ones((3, 4, 3), np.float32) * 3e38
    result, text = repaired(pixels, "error")
    assert result is pixels
    assert text == ""


def test_repaired_from_the_neighbours_and_counted() -> None:
    pixels = np.full((5, 5, 3), 2.0, np.float32)
    pixels[2, 2, 0] = np.nan
    pixels[0, 0] = np.inf
    pixels[4, 4, 1] = -np.inf
    assert count(pixels) == (1, 4)
    result, text = repaired(pixels.copy(), "repair")
    np.testing.assert_array_equal(result, 2.0)
    assert text.startswith("1 NaN and 4 Inf repaired")


def test_other_values_stay() -> None:
    rng = np.random.default_rng(0)
    pixels = rng.random((20, 30, 4), np.float32)
    bad = rng.random(pixels.shape) < 0.2
    broken = np.where(bad, np.float32("nan"), pixels)
    first, _ = repaired(broken.copy(), "repair")
    second, _ = repaired(broken.copy(), "repair")
    assert np.isfinite(first).all()
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(first[~bad], pixels[~bad])


def test_nothing_finite_is_black() -> None:
    result, _ = repaired(np.full((4, 4, 3), np.nan, np.float32), "repair")
    np.testing.assert_array_equal(result, 0)


def test_refused_with_the_count() -> None:
    pixels = np.ones((2, 2, 3), np.float32)
    pixels[0, 0, 0], pixels[1, 1, 1], pixels[0, 1] = np.nan, -np.inf, np.inf
    with pytest.raises(ReadError, match="1 NaN and 4 Inf") as caught:
        repaired(pixels, "error")
    assert (caught.value.code, caught.value.parameter) == ("non-finite", "nonfinite")


def test_said() -> None:
    assert said(6, 12) == "6 NaN and 12 Inf"
    assert said(0, 1) == "1 Inf"


def test_colour_over_a_tiny_alpha_is_refused_with_its_place(tmp_path: Path) -> None:
    pixels = colors(6, 8, 4, dtype=np.float32)
    pixels[2, 3] = (1, 1, 1, 1e-39)
    path = exr(tmp_path / "a.exr", planes(pixels))
    with pytest.raises(ReadError, match=r"over its alpha is NaN or Inf in 1 pixel, the first at x 3, y 2") as caught:
        read_image(path, colorspace="sRGB")
    assert caught.value.file == str(path)
    assert np.isfinite(read_image(path).pixels).all()
