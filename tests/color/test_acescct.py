"""ACEScct code values at values of Academy S-2016-001."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import color

WHITE = 9.72 / 17.52  # ACEScct of 1.0: code value 255


def codes_of(value: float) -> np.ndarray:
    """Code values of a grey of AP1."""
    return color.encode(np.full((1, 1, 3), value, np.float32), "acescct", "lin_ap1_scene")[0, 0]


@pytest.mark.parametrize(
    ("linear", "acescct"),
    [
        (0.0, 0.0729055341958355),
        (0.0078125, 0.155251141552511),  # where the line ends
        (0.18, 0.4135884),
        (1.0, WHITE),
        (65504.0, 1.4679964),
        (-0.001, -0.001 * 10.5402377416545 + 0.0729055341958355),
    ],
)
def test_values_of_the_standard(linear: float, acescct: float) -> None:
    assert codes_of(linear) == pytest.approx(np.full(3, acescct * 255 / WHITE), rel=1e-6)


def test_every_stop_counts_the_same() -> None:
    stops = [codes_of(2.0**stop)[0] for stop in range(-3, 7)]
    np.testing.assert_allclose(np.diff(stops), 255 / 9.72, atol=1e-3)
    assert codes_of(1.0)[0] == 255


def test_luminance_is_that_of_ap1() -> None:
    rgb = np.float32([[[0.2, 0.4, 0.9]]])
    y = 0.2722287167809146 * 0.2 + 0.6740817658111483 * 0.4 + 0.05368951740793703 * 0.9
    mono = color.encode_mono(rgb, "acescct", "lin_ap1_scene")
    np.testing.assert_allclose(mono, codes_of(y)[:1, None], rtol=1e-6)


def test_code_values_come_back() -> None:
    rgb = np.random.default_rng(6).uniform(-0.01, 64, (4, 19, 3)).astype(np.float32)
    np.testing.assert_allclose(color.decode(color.encode(rgb, "acescct"), "acescct"), rgb, rtol=1e-5, atol=1e-3)
