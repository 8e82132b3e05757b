"""The sRGB curve at values of IEC 61966-2-1."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes.color import srgb

# sRGB and linear light, by the standard's formula in float64
PAIRS = [(0.0, 0.0), (0.04, 0.04 / 12.92), (0.5, 0.21404114048223255), (0.735356983052449, 0.5), (1.0, 1.0)]


@pytest.mark.parametrize(("code", "light"), PAIRS)
def test_known_values(code: float, light: float) -> None:
    assert srgb.linear(np.float32([code])) == pytest.approx([light], rel=1e-6)
    assert srgb.encoded(np.float32([light])) == pytest.approx([code], rel=1e-6)


def test_white_and_black_are_exact() -> None:
    ends = np.float32([0, 1])
    np.testing.assert_array_equal(srgb.linear(ends), ends)
    np.testing.assert_array_equal(srgb.encoded(ends), ends)


def test_below_0_the_line_continues_and_above_1_the_power() -> None:
    assert srgb.linear(np.float32([-0.5])) == pytest.approx([-0.5 / 12.92])
    assert srgb.linear(np.float32([2.0])) == pytest.approx([((2 + 0.055) / 1.055) ** 2.4])


def test_decoding_is_the_inverse() -> None:
    light = np.linspace(-0.5, 4, 1001, dtype=np.float32).reshape(7, 143)
    back = srgb.linear(srgb.encoded(light))
    assert back.dtype == np.float32
    np.testing.assert_allclose(back, light, rtol=2e-6, atol=1e-7)
