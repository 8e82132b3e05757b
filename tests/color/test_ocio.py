"""Pixels from and to encoded spaces: sRGB exactly, others through OCIO."""

import warnings

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.errors import ArgumentError, ColorError

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

REC709 = color.space("lin_rec709")
SRGB = [
    "srgb_rec709_scene",
    "sRGB",
    "sRGB - Display",
    "srgb_tx",
    "srgb_rec709_display",
    "sRGB - Texture",
    "srgb_display",
]


def grey(values):
    return np.repeat(np.asarray(values, np.float32).reshape(1, -1, 1), 3, axis=2)


@pytest.mark.parametrize("name", SRGB)
def test_srgb_is_colour_sciences(name):
    codes = np.linspace(0, 1.5, 4001)
    rgb, space = color.ocio.linearize(grey(codes), name)
    assert space == REC709
    np.testing.assert_allclose(rgb[0, :, 0], colour.models.eotf_sRGB(codes), rtol=1e-6, atol=1e-9)
    back = color.ocio.encode_named(rgb, space, name)
    np.testing.assert_allclose(back[0, :, 0], codes, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize("steps", [255, 65535])
def test_every_srgb_code_comes_back(steps):
    codes = np.arange(steps + 1)
    rgb, space = color.ocio.linearize(grey(codes / steps), "sRGB")
    assert rgb[0, -1].tolist() == [1, 1, 1]
    assert rgb[0, 0].tolist() == [0, 0, 0]
    back = color.ocio.encode_named(rgb, space, "sRGB")
    np.testing.assert_array_equal(np.rint(back[0, :, 0].astype(np.float64) * steps), codes)


def test_srgb_of_negative_and_bright_values():
    rgb = grey([-0.5, -1e-3, 2, 65504])
    back, _ = color.ocio.linearize(color.ocio.encode_named(rgb, REC709, "sRGB"), "sRGB")
    np.testing.assert_allclose(back, rgb, rtol=2e-6)


@pytest.mark.parametrize(
    ("name", "primaries"),
    [
        ("ACEScct", "lin_ap1_scene"),
        ("ocio:acescct_ap1_scene", "lin_ap1_scene"),
        ("g22_rec709_scene", "lin_rec709"),
        ("srgb_p3d65_scene", "lin_p3d65_scene"),
        ("srgb_ap1_scene", "lin_ap1_scene"),
        ("Rec.1886 Rec.2020 - Display", "lin_rec2020_scene"),
        ("ARRI LogC3 (EI800)", "lin_ap0_scene"),
    ],
)
def test_encodings_go_to_their_own_primaries_and_back(name, primaries):
    codes = np.random.default_rng(0).uniform(0.2, 0.8, (5, 6, 3)).astype(np.float32)
    rgb, space = color.ocio.linearize(codes, name)
    assert space.name == primaries
    np.testing.assert_allclose(color.ocio.encode_named(rgb, space, name), codes, atol=5e-4)


def test_acescct_is_colour_sciences():
    codes = np.linspace(0.1, 1.2, 200).reshape(1, -1, 1) * np.ones(3)
    rgb, _ = color.ocio.linearize(codes.astype(np.float32), "ACEScct")
    np.testing.assert_allclose(rgb, colour.models.log_decoding_ACEScct(codes), rtol=2e-5, atol=1e-6)


def test_from_any_space_to_any_encoding():
    ap1 = color.space("ACEScg")
    rgb = np.random.default_rng(0).uniform(0.05, 1, (3, 4, 3)).astype(np.float32)
    encoded = color.ocio.encode_named(rgb, ap1, "sRGB")
    back, _ = color.ocio.linearize(encoded, "sRGB")
    expected = colour.RGB_to_RGB(rgb, "ACEScg", "ITU-R BT.709", "Bradford")
    np.testing.assert_allclose(back, expected, atol=1e-4)
    assert (color.ocio.encode_named(np.ones((1, 1, 3), np.float32), ap1, "sRGB") == 1).all()


def test_linear_names_only_change_primaries():
    rgb = np.random.default_rng(0).uniform(-0.2, 8, (3, 4, 3)).astype(np.float32)
    same, space = color.ocio.linearize(rgb, "ACEScg")
    assert space.name == "lin_ap1_scene"
    np.testing.assert_array_equal(same, rgb)
    np.testing.assert_array_equal(color.ocio.encode_named(rgb, REC709, "lin_rec709"), rgb)
    there = color.ocio.encode_named(rgb, REC709, "ACEScg")
    np.testing.assert_allclose(color.ocio.encode_named(there, space, "lin_rec709"), rgb, atol=1e-5)
    own = color.space_from_chromaticities((0.7, 0.3), (0.2, 0.7), (0.1, 0.05), (0.3127, 0.329))
    np.testing.assert_allclose(
        color.ocio.encode_named(color.ocio.encode_named(rgb, REC709, own.name), own, "lin_rec709"), rgb, atol=1e-5
    )


def test_raw_is_left_alone():
    rgb = np.float32([[[0.2, -3, 70]]])
    found, space = color.ocio.linearize(rgb, "raw")
    assert space == REC709
    np.testing.assert_array_equal(found, rgb)
    np.testing.assert_array_equal(color.ocio.encode_named(rgb, color.space("ACEScg"), "data"), rgb)


@pytest.mark.parametrize("name", ["sRGB", "ACEScct", "lin_ap1_scene", "raw"])
def test_alpha_and_the_input_stay(name):
    rgba = np.random.default_rng(0).uniform(0.2, 0.8, (3, 4, 4)).astype(np.float32)
    before = rgba.copy()
    rgb, _space = color.ocio.linearize(rgba, name)
    encoded = color.ocio.encode_named(rgba, REC709, name)
    for result in (rgb, encoded):
        assert result.shape == (3, 4, 4)
        assert result.dtype == np.float32
        assert result.flags.c_contiguous
        np.testing.assert_array_equal(result[..., 3], before[..., 3])
    np.testing.assert_array_equal(rgba, before)
    np.testing.assert_array_equal(rgb[..., :3], color.ocio.linearize(rgba[..., :3], name)[0])


def test_errors():
    with pytest.raises(ColorError, match="'sRGV'") as caught:
        color.ocio.linearize(grey([0.5]), "sRGV")
    assert "sRGB" in caught.value.hint
    for shape in [(4, 4), (4, 4, 1), (4, 4, 5)]:
        with pytest.raises(ArgumentError, match=r"\(H, W, 3\)"):
            color.ocio.linearize(np.zeros(shape, np.float32), "sRGB")
