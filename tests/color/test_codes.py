"""Code values against colour-science in float64, round trips, neutrals, threads, errors."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from flowabs_nodes import color
from flowabs_nodes.color.codes import encoded
from flowabs_nodes.color.spaces import KNOWN, SOURCES, normalised, to_ap1
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.simd import bands

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

BOTH = pytest.mark.parametrize("space", color.SPACES)
EVERY_SPACE = pytest.mark.parametrize("name", KNOWN)


def pixels(low=-0.5, high=64.0, shape=(48, 64), seed=0):
    """Random RGB; a fifth of it saturated, a fifth near black."""
    rng = np.random.default_rng(seed)
    rgb = rng.uniform(low, high, (*shape, 3))
    rgb *= np.where(rng.random((*shape, 1)) < 0.2, rng.random((*shape, 3)) < 0.5, 1)
    rgb *= np.where(rng.random((*shape, 1)) < 0.2, 1e-3, 1)
    return rgb.astype(np.float32)


def white_of(name):
    return colour.XYZ_to_xy(np.array(KNOWN[name].to_xyz).reshape(3, 3).sum(axis=1))


def acescct(linear):
    with np.errstate(divide="ignore", invalid="ignore"):
        return colour.models.log_encoding_ACEScct(linear) * 255 / colour.models.log_encoding_ACEScct(1.0)


@EVERY_SPACE
@pytest.mark.parametrize("high", [1.0, 64.0])
def test_lab_is_colour_sciences(name, high):
    rgb = pixels(high=high)
    xyz = rgb.astype(np.float64) @ np.array(KNOWN[name].to_xyz).reshape(3, 3).T
    xyz /= np.array(KNOWN[name].to_xyz)[3:6].sum()  # Adobe's published Y of white is .99999
    expected = colour.XYZ_to_Lab(xyz, white_of(name))
    size = np.maximum(1, np.abs(expected) / 100)
    found = color.encode(rgb, "lab", name) / 2.55
    assert np.abs((found - expected) / size)[..., 0].max() < 1e-4  # of L* 0..100
    assert np.abs((found - expected) / size).max() < 1e-3


@EVERY_SPACE
def test_acescct_is_colour_sciences(name):
    rgb = pixels()
    source, target = colour.RGB_COLOURSPACES[SOURCES[name][0]], colour.RGB_COLOURSPACES["ACEScg"]
    np.testing.assert_allclose(to_ap1(KNOWN[name]), colour.matrix_RGB_to_RGB(source, target, "Bradford"), atol=2e-5)
    expected = acescct(rgb.astype(np.float64) @ to_ap1(KNOWN[name]).T)
    found = color.encode(rgb, "acescct", name)
    np.testing.assert_allclose(found, expected, rtol=3e-7, atol=1e-3)


def test_acescct_mono_is_of_ap1_luminance():
    rgb = pixels()
    ap1 = rgb.astype(np.float64) @ to_ap1(KNOWN["lin_rec709"]).T
    y = ap1 @ colour.RGB_COLOURSPACES["ACEScg"].matrix_RGB_to_XYZ[1]
    expected = acescct(y)
    np.testing.assert_allclose(color.encode_mono(rgb, "acescct"), expected, rtol=3e-7, atol=1e-3)


@EVERY_SPACE
def test_lab_mono_is_the_same_bits(name):
    rgb = pixels()
    np.testing.assert_array_equal(color.encode_mono(rgb, "lab", name), color.encode(rgb, "lab", name)[..., 0])


@EVERY_SPACE
@BOTH
def test_neutrals(name, space):
    grey = np.float32([[0, 1, 0.18, 1e-6, -0.3, 7, 65504]])
    codes = color.encode(np.repeat(grey[..., None], 3, axis=2), space, name)
    if space == "lab":
        assert (codes[..., 1:] == 0).all()
    else:
        assert (codes == codes[..., :1]).all()
    assert codes[0, 1, 0] == pytest.approx(255, abs=5e-5)
    assert color.encode_mono(np.repeat(grey[..., None], 3, axis=2), space, name) == pytest.approx(
        codes[..., 0], rel=1e-6
    )
    back = color.decode(codes, space, name)
    assert (back == back[..., :1]).all()


def test_known_values():
    codes = color.encode(np.float32([[[1, 1, 1], [0, 0, 0], [0.18, 0.18, 0.18], [-0.01, -0.01, -0.01]]]), "lab")
    assert codes[0, :, 0] / 2.55 == pytest.approx([100, 0, 49.496, -9.033], abs=1e-3)
    # Two stops are two equal steps: 255 / (.5547945 * 17.52) codes each.
    steps = np.diff(color.encode_mono(np.full((1, 3, 3), 0.5, np.float32) * np.float32([1, 2, 4])[:, None], "acescct"))
    assert steps[0] == pytest.approx([26.2346, 26.2346], abs=1e-4)


def held(rgb, space, negative_luminance=False):
    """How far from where it was a colour may come back."""
    size = np.abs(rgb).max(axis=2, keepdims=True).astype(np.float64)
    if space == "acescct":
        return size * 2e-5 + 1e-8  # the code of black is 33.5, and float32 has no finer steps there
    if negative_luminance:  # a large number less a large number: see the notes of color.encode
        return size * (2e-5 + 8e-6 * size ** (2 / 3)) + 1e-37
    return size * 2e-5


@EVERY_SPACE
@BOTH
@pytest.mark.parametrize("high", [1e-3, 1.0, 64.0, 65504.0, 1e6])
def test_round_trip(name, space, high):
    rgb = pixels(low=-min(0.5, high / 2), high=high)
    back = color.decode(color.encode(rgb, space, name), space, name)
    negative_luminance = name == "lin_ap0_scene" and high > 64  # its blue has one
    assert (np.abs(back - rgb) <= held(rgb, space, negative_luminance)).all()


@BOTH
@settings(deadline=None)  # the first example compiles
@given(
    rgb=hnp.arrays(
        np.float32, (1, 5, 3), elements=st.floats(-(2**20), 2**20, width=32) | st.floats(-(2**-20), 2**-20, width=32)
    )
)
def test_every_finite_value_comes_back(space, rgb):
    codes = color.encode(rgb, space)
    assert np.isfinite(codes).all()
    back = color.decode(codes, space)
    assert (np.abs(back - rgb) <= held(rgb, space, negative_luminance=True)).all()


@BOTH
def test_extremes_stay_finite(space):
    rgb = np.float32([[[65504, -65504, 0], [1e30, 1e30, 1e30], [3e38, 0, 0], [1e-45, -1e-45, 0], [-1e6, 0, 1e6]]])
    codes = color.encode(rgb, space)
    assert np.isfinite(codes).all()
    assert np.isfinite(color.encode_mono(rgb, space)).all()
    assert np.isfinite(color.decode(codes, space)).all()
    assert np.isfinite(color.decode(np.full((1, 1, 3), 1e5, np.float32), space)).all()


@BOTH
def test_brighter_is_never_darker(space):
    breaks = [216 / 24389, 0.0078125]  # where toe and curve meet
    fine = np.concatenate(
        [np.nextafter(np.float32(b), np.float32(1)) * np.linspace(0.999, 1.001, 4001) for b in breaks]
    )
    wide = np.geomspace(1e-6, 1e5, 20001)
    for ramp in (np.sort(fine), wide, -wide[::-1]):
        grey = np.repeat(ramp.astype(np.float32)[None, :, None], 3, axis=2)
        step = np.diff(color.encode_mono(grey, space).astype(np.float64))
        assert step.min() > -1e-4  # the standards' own curves meet to 1e-6 only


@BOTH
def test_same_bits_at_any_number_of_threads(space):
    rgb = pixels(shape=(61, 47))
    results = []
    for count in (1, 2, 3):
        with bands.limited(count):
            codes = color.encode(rgb, space)
            results.append((codes, color.decode(codes, space), color.encode_mono(rgb, space)))
    for result in results[1:]:
        for first, other in zip(results[0], result, strict=True):
            np.testing.assert_array_equal(first, other)


@BOTH
def test_a_pixel_does_not_depend_on_its_place(space):
    rgb = pixels(shape=(3, 37))
    whole = color.encode(rgb, space)
    for x in (0, 15, 36):
        np.testing.assert_array_equal(color.encode(rgb[1:2, x : x + 1], space)[0, 0], whole[1, x])


def test_any_array_of_numbers_is_taken():
    rgb = pixels(low=0, high=1)
    expected = color.encode(rgb)
    frozen = rgb.copy()
    frozen.setflags(write=False)
    wide = np.zeros((*rgb.shape[:2], 4), np.float32)
    wide[..., :3] = rgb
    for same in (rgb.astype(np.float64), np.asfortranarray(rgb), frozen, wide[..., :3], rgb[::-1][::-1]):
        np.testing.assert_array_equal(color.encode(same), expected)
    assert color.encode(np.ones((1, 1, 3), np.uint8))[0, 0, 0] == pytest.approx(255)
    assert color.encode(np.ones((1, 1, 3), bool)).dtype == np.float32
    assert color.encode(rgb.astype(np.float16)).dtype == np.float32


@pytest.mark.parametrize("function", [color.encode, color.decode, color.encode_mono])
@pytest.mark.parametrize(
    ("value", "message"),
    [
        (np.zeros((4, 4)), r"expected shape \(H, W, 3\).*\(4, 4\)"),
        (np.zeros((4, 4, 4)), r"\(4, 4, 4\)"),
        (np.zeros((0, 4, 3)), "at least one pixel"),
        (np.zeros((4, 4, 3), complex), "complex128"),
        (np.full((4, 4, 3), "a"), "real numbers"),
        (np.float32([[[np.nan, 0, np.inf], [1, 1, -np.inf]]]), "found 3 that are NaN or Inf"),
        (np.full((1, 1, 3), 1e300), "found 3"),
    ],
)
def test_errors_name_the_argument(function, value, message):
    with pytest.raises(ArgumentError, match=message) as caught:
        function(value)
    assert caught.value.parameter == ("codes" if function is color.decode else "rgb")


@pytest.mark.parametrize("function", [color.encode, color.decode, color.encode_mono])
def test_unknown_names(function):
    rgb = np.zeros((1, 1, 3), np.float32)
    with pytest.raises(ArgumentError, match="found 'lap'") as caught:
        function(rgb, space="lap")
    assert "'lab'" in caught.value.hint
    with pytest.raises(ColorError, match="lin_rec70'"):
        function(rgb, colorspace="lin_rec70")


def test_matrices_keep_white():
    for space in KNOWN.values():
        np.testing.assert_allclose(normalised(space).sum(axis=1), 1, atol=1e-15)
        np.testing.assert_allclose(to_ap1(space).sum(axis=1), 1, atol=1e-15)


@BOTH
@pytest.mark.parametrize("light", [np.nan, np.inf, -np.inf, -3e38, -1e35, -2e31])
@pytest.mark.parametrize("channels", [[0], [1], [2], [0, 1, 2]])
def test_light_without_code_values_is_refused(space, light, channels):
    rgb = np.full((5, 9, 3), 0.5, np.float32)
    rgb[3, 4, channels] = light
    if light != -2e31 or 1 in channels:  # one channel may count too little to be beyond
        with pytest.raises(ArgumentError, match=r"rgb: .* the first .*at x 4, y 3"):
            color.encode(rgb, space)
        with pytest.raises(ArgumentError, match=r"rgb: .* the first .*at x 4, y 3"):
            color.encode_mono(rgb, space)


@BOTH
@pytest.mark.parametrize("light", [3e38, 1e30, -1e30, -1e20])
def test_enormous_light_comes_back(space, light):
    rgb = np.full((5, 9, 3), 0.5, np.float32)
    rgb[3, 4] = light
    if space == "lab" or light < 2e38:
        np.testing.assert_allclose(color.decode(color.encode(rgb, space), space), rgb, rtol=1e-4)


@BOTH
def test_light_that_alpha_divides_beyond_float32_is_refused_with_its_place(space):
    rgba = np.full((5, 9, 4), 0.5, np.float32)
    rgba[3, 4] = (1e20, 1, 1, 1e-19)
    with pytest.raises(ArgumentError, match=r"rgb: .* the first 1e\+20 1 1 1e-19 at x 4, y 3"):
        encoded(rgba, space, color.space("lin_rec709"))
    rgba[3, 4, 3] = 1e-20  # counts as 0
    assert np.isfinite(encoded(rgba, space, color.space("lin_rec709"))[0]).all()
