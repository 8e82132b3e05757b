"""Lab code values at values of CIE 15."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import color


def codes_of(*rgb: float) -> np.ndarray:
    return color.encode(np.float32([[rgb]]), "lab")[0, 0]


@pytest.mark.parametrize(
    ("y", "lstar"),
    [
        (0.0, 0.0),
        (0.18, 49.49609),
        (1.0, 100.0),
        (216 / 24389, 8.0),  # where the toe ends
        (0.001, 0.9032963),  # 24389 / 27 y
        (-0.01, -9.032963),  # the toe's line goes on
        (8.0, 216.0),  # and so does the cube root: 116 * 2 - 16
    ],
)
def test_lightness_of_greys(y: float, lstar: float) -> None:
    lightness, a, b = codes_of(y, y, y)
    assert lightness / 2.55 == pytest.approx(lstar, rel=1e-5, abs=1e-6)
    assert (a, b) == (0, 0), "neutral to the last bit"


def test_red_of_rec709() -> None:
    """L*a*b* of linear (1, 0, 0) over D65, as colour calculators give it."""
    assert codes_of(1, 0, 0) / 2.55 == pytest.approx([53.24, 80.09, 67.20], abs=0.02)


def test_lightness_alone_has_the_same_bits() -> None:
    rgb = np.random.default_rng(5).uniform(-0.2, 3, (4, 19, 3)).astype(np.float32)
    np.testing.assert_array_equal(color.encode_mono(rgb, "lab"), color.encode(rgb, "lab")[..., 0])


def test_code_values_come_back() -> None:
    rgb = np.random.default_rng(6).uniform(0, 8, (4, 19, 3)).astype(np.float32)
    np.testing.assert_allclose(color.decode(color.encode(rgb, "lab"), "lab"), rgb, atol=2e-4)
