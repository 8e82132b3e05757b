"""Images of what hosts hold, and what hosts hold of images."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.color import srgb
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.testing.pictures import make_input

RANDOM = np.random.default_rng(5)
RGBA = RANDOM.random((6, 8, 4), np.float32)
BYTES = RANDOM.integers(0, 256, (6, 8, 4), np.uint8)


# ---------------------------------------------------------------------- hosts


def test_blender_float_pixels() -> None:
    """``Image.pixels``: one list of float32, the lowest row first."""
    pixels = np.ascontiguousarray(RGBA[::-1]).ravel()
    image = Image.from_array(pixels, shape=(6, 8, 4), rows="bottom-up")
    np.testing.assert_array_equal(image.pixels, RGBA)
    given = np.empty_like(pixels)
    assert image.to_array(out=given, rows="bottom-up") is given
    np.testing.assert_array_equal(given, pixels)


def test_blender_byte_pixels() -> None:
    """``Image.pixels`` of a PNG: sRGB codes as floats 0..1, straight alpha."""
    kind: dict[str, Any] = {"encoding": "sRGB", "alpha": "straight", "rows": "bottom-up"}
    codes = BYTES.copy()
    codes[..., 3] = codes[..., 3].clip(1)
    pixels = np.float32(codes[::-1].ravel() / 255)
    image = Image.from_array(pixels, shape=(6, 8, 4), **kind)
    alpha = codes[..., 3:] / np.float32(255)
    np.testing.assert_array_equal(image.pixels[..., 3:], alpha)
    np.testing.assert_allclose(image.pixels[..., :3], srgb.linear(codes[..., :3] / np.float32(255)) * alpha, rtol=1e-6)
    given = image.to_array(out=np.empty_like(pixels), **kind)
    np.testing.assert_array_equal(np.rint(given * 255), codes[::-1].ravel())


@pytest.mark.parametrize("gap", [0, 48])
@pytest.mark.parametrize("upwards", [False, True])
def test_openfx_memory(gap: int, upwards: bool) -> None:
    """A pointer, and row bytes that may be negative; the first row is the lowest."""
    step = 8 * 16 + gap
    memory = (ctypes.c_char * (6 * step))()
    shown: dict[str, Any] = {"rows": "bottom-up", "row_bytes": -step if upwards else step}
    image = Image.from_array(RGBA)
    image.to_array(out=memory, dtype="float32", **shown)
    in_memory = np.frombuffer(memory, np.float32).reshape(6, step // 4)[:, :32].reshape(6, 8, 4)
    np.testing.assert_array_equal(in_memory, RGBA if upwards else RGBA[::-1])
    again = Image.from_array(memory, shape=(6, 8, 4), dtype="float32", **shown)
    np.testing.assert_array_equal(again.pixels, RGBA)


@pytest.mark.parametrize(("channels", "alpha"), [("BGRA", "straight"), ("BGRA", "premultiplied"), ("BGRX", None)])
def test_qt_memory(channels: str, alpha: str | None) -> None:
    """``QImage.constBits()`` of Format_ARGB32, ARGB32_Premultiplied and RGB32: bytes in the order B, G, R, A."""
    codes = BYTES.copy()
    codes[..., 3] = codes[..., 3].clip(1)
    kind: dict[str, Any] = {"encoding": "sRGB", "alpha": alpha, "channels": channels}
    image = Image.from_array(memoryview(codes.tobytes()), shape=(6, 8, 4), row_bytes=32, **kind)
    assert image.channels == (("R", "G", "B") if channels == "BGRX" else ("R", "G", "B", "A"))
    bits = bytearray(codes.nbytes)
    assert image.to_array(out=bits, dtype="uint8", **kind) is bits
    expected = codes.copy()
    if channels == "BGRX":
        expected[..., 3] = 255
        np.testing.assert_allclose(image.pixels[..., 0], srgb.linear(codes[..., 2] / np.float32(255)), rtol=1e-6)
    np.testing.assert_array_equal(np.frombuffer(bits, np.uint8).reshape(codes.shape), expected)


# ---------------------------------------------------------------------- there and back


def test_light_comes_back_in_its_own_bits() -> None:
    odd = RGBA.copy()
    odd.view(np.uint32)[0, 0] = 0x7FC12345, 0xFF800000, 0x80000000, 0x00000001  # NaN, -Inf, -0, the least number
    for colorspace in ("lin_rec709", "ACEScg"):
        image = Image.from_array(odd, colorspace)
        found = image.to_array(colorspace=colorspace)
        np.testing.assert_array_equal(found.view(np.uint32), odd.view(np.uint32))
        assert np.shares_memory(found, image.pixels)


@pytest.mark.parametrize("rows", ["top-down", "bottom-up"])
@pytest.mark.parametrize("channels", [None, "RGBA", "RGB", "A", ("G", "B")])
def test_what_needs_no_conversion_is_a_read_only_view(rows: str, channels: Any) -> None:
    image = Image.from_array(RGBA)
    found = image.to_array(rows=rows, channels=channels)
    assert np.shares_memory(found, image.pixels)
    assert not found.flags.writeable
    picks = ["RGBA".index(name) for name in channels or "RGBA"]
    np.testing.assert_array_equal(found[:: -1 if rows == "bottom-up" else 1], RGBA[..., picks])


def test_without_alpha_nothing_is_straight() -> None:
    for count in (1, 3):
        image = Image.from_array(RGBA[..., :count])
        assert np.shares_memory(image.to_array(alpha="straight"), image.pixels)


def test_what_needs_one_is_a_copy_of_its_own() -> None:
    image = Image.from_array(RGBA)
    for changes in ({"alpha": "straight"}, {"dtype": "float16"}, {"channels": "BGRA"}, {"encoding": "sRGB"}):
        found = image.to_array(**changes)
        assert found.flags.writeable
        assert not np.shares_memory(found, image.pixels)


@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64, ">f4"])
@pytest.mark.parametrize("encoding", [None, "linear", "sRGB", "ACEScct"])
@pytest.mark.parametrize("alpha", ["premultiplied", "straight"])
@pytest.mark.parametrize("count", [1, 3, 4])
def test_floats_come_back_nearly_as_they_were(dtype: Any, encoding: str | None, alpha: str, count: int) -> None:
    kind: dict[str, Any] = {"encoding": encoding, "alpha": alpha, "rows": "bottom-up"}
    array = 0.2 + 0.6 * RGBA[..., :count]
    if alpha == "premultiplied" and count == 4:
        array[..., :3] *= array[..., 3:]
    array = array.astype(dtype)
    image = Image.from_array(array, **kind)
    found = image.to_array(dtype=dtype, **kind)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, array, rtol=2e-3 if dtype == np.float16 else 3e-6, atol=1e-6)
    image.to_array(out=array, **kind)
    np.testing.assert_array_equal(array, found)


def test_memory_with_any_strides_is_read_and_filled() -> None:
    wide = np.zeros((12, 8, 8), np.float32)
    for view in (wide[::2, :, ::2], wide[10::-2, ::-1, :4], np.asfortranarray(np.zeros_like(RGBA))):
        view[...] = RGBA
        image = Image.from_array(view)
        np.testing.assert_array_equal(image.pixels, RGBA)
        view[...] = 0
        assert image.to_array(out=view) is view
        np.testing.assert_array_equal(view, RGBA)
        np.testing.assert_array_equal(image.pixels, RGBA)


@pytest.mark.parametrize("size", [(1, 1), (1, 70000), (3000, 1)])
def test_pictures_of_any_size(size: tuple[int, int]) -> None:
    codes = RANDOM.integers(1, 256, (*size, 4), np.uint8)
    kind: dict[str, Any] = {"encoding": "sRGB", "rows": "bottom-up"}
    np.testing.assert_array_equal(Image.from_array(codes, **kind).to_array(dtype="uint8", **kind), codes)


# ---------------------------------------------------------------------- types that are no colour


@pytest.mark.parametrize("kind", ["matte", "flow", "depth", "normal", "motion", "id", "data"])
def test_types_that_are_no_colour_are_not_encoded(kind: str) -> None:
    image = make_input(kind, "noise", 6, 8)
    said: dict[str, Any] = {"encoding": "sRGB", "alpha": "straight", "rows": "bottom-up"}
    dtype = np.uint32 if kind == "id" else np.float32
    found = image.to_array(**said)
    np.testing.assert_array_equal(found, image.pixels[::-1])
    assert found.dtype == dtype
    again = Image.from_array(found, type=kind, channels=image.channels, **said)
    np.testing.assert_array_equal(again.pixels, image.pixels)
    out = np.empty(image.pixels.size, dtype)
    np.testing.assert_array_equal(image.to_array(out=out, **said).reshape(found.shape), found)


def test_a_matte_of_bytes() -> None:
    codes = BYTES[..., 0]
    matte = Image.from_array(codes, type="matte", encoding="sRGB")
    np.testing.assert_array_equal(matte.pixels[..., 0], codes / np.float32(255))
    np.testing.assert_array_equal(matte.to_array(dtype="uint8")[..., 0], codes)
    shown = matte.to_array(dtype="uint8", channels="RGBA")
    np.testing.assert_array_equal(shown[..., :3], codes[..., None].repeat(3, axis=2))
    assert (shown[..., 3] == 255).all()


def test_ids_are_never_rounded() -> None:
    ids = Image.from_array(np.array([[7, 2**24 + 1]], np.uint32), type="id")
    assert ids.to_array(dtype="float64").ravel().tolist() == [7, 2**24 + 1]
    for dtype in ("float32", "uint16"):
        with pytest.raises(
            ArgumentError, match=rf"holds every id, found {dtype}, which cannot hold 16777217 at x 1, y 0"
        ):
            ids.to_array(dtype=dtype)
    depth = Image.from_array(np.array([[7, 200]], np.uint8), type="depth")
    assert depth.to_array(dtype="uint8").ravel().tolist() == [7, 200]


# ---------------------------------------------------------------------- windows, mistakes


def test_windows_are_given_with_the_pixels() -> None:
    image = Image.from_array(RGBA, data_window=(-2, 5, 8, 6), display_window=(0, 0, 20, 10))
    assert (image.data_window, image.display_window) == (Window(-2, 5, 8, 6), Window(0, 0, 20, 10))
    image = Image.from_array(RGBA, data_window=Window(3, 4, 8, 6))
    assert image.data_window == image.display_window == Window(3, 4, 8, 6)


@pytest.mark.parametrize(
    ("arguments", "parameter", "message"),
    [
        ({"data_window": (0, 0, 6, 8)}, "data_window", "expected one of 8x6, as the array is, found 6x8"),
        ({"data_window": (0, 0)}, "data_window", r"expected four whole numbers .*found \(0, 0\)"),
        ({"data_window": (0.5, 0, 8, 6)}, "data_window", "four whole numbers"),
        ({"display_window": (0, 0, 0, 6)}, "display_window", "four whole numbers"),
        ({"display_window": "8x6"}, "display_window", "found '8x6'"),
        ({"rows": "flipped"}, "rows", "found 'flipped'"),
        ({"shape": (6, 8, 3)}, "array", "expected 576 bytes"),
    ],
)
def test_mistakes_of_what_is_taken(arguments: dict[str, Any], parameter: str, message: str) -> None:
    with pytest.raises(ArgumentError, match=message) as error:
        Image.from_array(RGBA, **arguments)
    assert error.value.parameter == parameter


READ_ONLY = np.zeros_like(RGBA)
READ_ONLY.flags.writeable = False


@pytest.mark.parametrize(
    ("arguments", "parameter", "message"),
    [
        ({"dtype": "uint8"}, "encoding", "such as 'sRGB', for uint8 of scene-linear light, found none"),
        ({"dtype": "int32", "encoding": "sRGB"}, "dtype", "expected uint8, uint16 or floats for a color, found int32"),
        ({"dtype": "float23"}, "dtype", "did you mean 'float32'"),
        ({"out": READ_ONLY}, "out", "can be written to, found read-only"),
        ({"out": bytes(768), "dtype": "float32"}, "out", "found read-only"),
        ({"out": np.zeros((6, 8, 3), np.float32)}, "out", r"expected shape \(6, 8, 4\), found \(6, 8, 3\) \(channels"),
        ({"out": np.zeros((8, 6, 4), np.float32)}, "out", r"found \(8, 6, 4\)$"),
        ({"out": np.zeros(191, np.float32)}, "out", "expected 768 bytes .* found 764"),
        ({"out": bytearray(768)}, "out", 'found 768 bytes .it would fit dtype="float32"'),
        ({"out": [0.0] * 192}, "out", "a buffer that can be written to, found list"),
        ({"out": np.zeros(192, complex)}, "out", "expected real numbers"),
        ({"row_bytes": 128}, "row_bytes", "expected a flat buffer as out"),
        ({"channels": "RGBZ"}, "channels", "has no 'Z'"),
        ({"rows": "up"}, "rows", "found 'up'"),
    ],
)
def test_mistakes_of_what_is_given_back(arguments: dict[str, Any], parameter: str, message: str) -> None:
    with pytest.raises(ArgumentError, match=message) as error:
        Image.from_array(RGBA).to_array(**arguments)
    assert error.value.parameter == parameter


def test_an_image_needs_no_making() -> None:
    with pytest.raises(ArgumentError, match="found an Image, which needs no making"):
        Image.from_array(Image.from_array(RGBA))
