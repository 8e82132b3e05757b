"""An ICC profile means its primaries and curves; one that cannot be read says why."""

from __future__ import annotations

import colour
import numpy as np
import pytest

from flowabs_nodes.color.icc import read_profile
from flowabs_nodes.errors import ColorError
from tests.color.profiles import RAMP, SRGB_CURVE, curve, parametric, profile, table_profile

CODES = np.array([[[0.1, 0.5, 0.9], [1, 0, 0.25]]], np.float32)


@pytest.mark.parametrize(
    ("space", "name"),
    [
        ("sRGB", "lin_rec709"),
        ("Adobe RGB (1998)", "lin_adobergb_scene"),
        ("P3-D65", "lin_p3d65_scene"),
        ("ITU-R BT.2020", "lin_rec2020_scene"),
        ("ACEScg", "lin_ap1_scene"),
    ],
)
def test_primaries_of_a_known_space(space: str, name: str) -> None:
    assert read_profile(profile(space), "x").space.name == name


def test_other_primaries_are_what_they_are() -> None:
    found = read_profile(profile("ProPhoto RGB", curve(1.8)), "x").space
    theirs = colour.RGB_COLOURSPACES["ProPhoto RGB"]
    np.testing.assert_allclose(np.array(found.to_xyz).reshape(3, 3), theirs.matrix_RGB_to_XYZ, atol=2e-3)


@pytest.mark.parametrize(
    ("curves", "linear"),
    [
        (curve(2.2), lambda x: x ** (round(2.2 * 256) / 256)),
        (curve([]), lambda x: x),
        (curve([0.0, 0.25, 1.0]), lambda x: np.interp(x, [0, 0.5, 1], [0, 0.25, 1])),
        (parametric(0, 1.8), lambda x: x**1.8),
        (parametric(1, 2.0, 0.5, 0.5), lambda x: (0.5 * x + 0.5) ** 2),
        (parametric(2, 2.0, 0.9, 0.0, 0.1), lambda x: (0.9 * x) ** 2 + 0.1),
        (SRGB_CURVE, colour.models.eotf_sRGB),
        (
            parametric(4, 2.0, 0.9, 0.0, 0.5, 0.2, 0.05, 0.01),
            lambda x: np.where(x >= 0.2, (0.9 * x) ** 2 + 0.05, 0.5 * x + 0.01),
        ),
    ],
)
def test_curves_go_there_and_back(curves: bytes, linear) -> None:
    transfer = read_profile(profile(curves=curves), "x").transfers[0]
    np.testing.assert_allclose(transfer.linear(RAMP), linear(RAMP), atol=1e-4)
    inside = RAMP[8:]
    np.testing.assert_allclose(transfer.codes(transfer.linear(inside)), inside, atol=1e-4)


def test_each_channel_has_its_curve() -> None:
    found = read_profile(profile(curves=[curve(1.0), curve(2.0), curve(3.0)]), "x")
    np.testing.assert_allclose(found.linear(CODES), CODES ** [1, 2, 3], atol=1e-6)
    np.testing.assert_allclose(found.encoded(found.linear(CODES)), CODES, atol=1e-6)


def test_grey() -> None:
    found = read_profile(profile(curves=curve(1.8), kind=b"GRAY"), "x")
    np.testing.assert_allclose(found.linear(CODES), CODES ** (round(1.8 * 256) / 256), atol=1e-6)
    assert found.profile == b""  # true of grey pixels only


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (table_profile(), "table of colours"),
        (profile(kind=b"CMYK"), "CMYK"),
        (b"", "describes"),
        (profile()[:140], "table of colours|damaged"),
        (profile()[:-220], "damaged"),
        (profile(curves=curve([1.0, 0.0])), "does not rise"),
        (profile(curves=parametric(0, -1.0)), "does not rise"),
        (profile(curves=b"cicp" + b"\0" * 20), "curves are"),
        (profile()[:128] + b"\xff" * 400, "tags"),
    ],
)
def test_what_cannot_be_read_says_why(data: bytes, why: str) -> None:
    with pytest.raises(ColorError, match=why) as caught:
        read_profile(data, "x")
    assert caught.value.code in ("bad-profile", "bad-chromaticities")
