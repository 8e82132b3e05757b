"""Pictures go from Blender's Image datablocks to flowabs and back: the right way up, in the right light."""

import os
from pathlib import Path

import bpy
import numpy as np
import pytest
from flowabs_blender import color_names
from flowabs_blender.fill_datablock import show
from flowabs_blender.read_datablock import image_of
from pictures import RNG, held, made, picture, rendered, write

import flowabs_nodes as fa
from flowabs_nodes.errors import FlowabsError, ReadError
from flowabs_nodes.io.read import read_image

# ---------------------------------------------------------------------- from Blender


def test_float_pixels_are_light() -> None:
    pixels = picture()
    image = image_of(made(pixels))
    assert (image.type, image.colorspace.name, image.channels) == ("color", "lin_rec709", ("R", "G", "B", "A"))
    np.testing.assert_array_equal(image.pixels, pixels)


def test_an_opaque_picture_has_no_alpha() -> None:
    pixels = picture()
    pixels[..., 3] = 1
    np.testing.assert_array_equal(image_of(made(pixels)).pixels, pixels[..., :3])


@pytest.mark.parametrize("packed", [False, True])
def test_a_png_is_decoded_as_its_file_is(packed: bool, tmp_path: Path) -> None:
    codes = RNG.integers(0, 256, (6, 5, 4)).astype(np.uint8)
    codes[..., 3] |= 64
    file = write(tmp_path / "a.png", codes, "uint8", ["R", "G", "B", "A"])
    datablock = bpy.data.images.load(file)
    if packed:
        datablock.pack()
        os.remove(file)
        write(tmp_path / "b.png", codes, "uint8", ["R", "G", "B", "A"])
    expected = read_image(tmp_path / ("b.png" if packed else "a.png"))
    image = image_of(datablock)
    assert image.colorspace == expected.colorspace
    np.testing.assert_array_equal(image.pixels, expected.pixels)


def test_codes_of_another_colour_space() -> None:
    codes = np.full((4, 4, 4), 0.5, np.float32)
    codes[..., 3] = 1
    datablock = made(codes, is_float=False)
    datablock.colorspace_settings.name = "Filmic Log"  # which only Blender's config has
    datablock.pixels.foreach_set(codes.ravel())
    np.testing.assert_allclose(image_of(datablock).pixels, 2 ** (-12.473931 + 16.5 * 128 / 255), rtol=1e-3)
    datablock.colorspace_settings.name = "Non-Color"
    datablock.pixels.foreach_set(codes.ravel())
    np.testing.assert_allclose(image_of(datablock).pixels, 128 / 255, atol=1e-6)


def test_the_colour_space_is_the_one_set_in_blender(tmp_path: Path) -> None:
    pixels = picture(channels=3)
    datablock = bpy.data.images.load(write(tmp_path / "a.exr", pixels))
    datablock.colorspace_settings.name = "ACEScg"
    image = image_of(datablock)
    assert image.colorspace.name == "lin_ap1_scene"
    np.testing.assert_array_equal(image.pixels, pixels)
    # Blender itself holds the pixels in its working space.
    np.testing.assert_allclose(show(image, "result").pixels[:3], held(datablock)[-1, 0, :3], rtol=2e-3, atol=2e-3)


def test_a_file_keeps_its_data_window_and_header(tmp_path: Path) -> None:
    pixels = picture()
    file = write(tmp_path / "a.exr", pixels, x=3, y=2, full_width=20, full_height=10)
    image = image_of(bpy.data.images.load(file))
    assert image.data_window == (3, 2, 7, 5)
    assert image.display_window == (0, 0, 20, 10)
    result = show(image, "result")
    assert tuple(result.size) == (20, 10)
    expected = np.zeros((10, 20, 4), np.float32)
    expected[2:7, 3:10] = pixels
    np.testing.assert_array_equal(held(result), expected)


def test_what_was_painted_counts_and_not_the_file(tmp_path: Path) -> None:
    datablock = bpy.data.images.load(write(tmp_path / "a.exr", picture()))
    painted = picture()
    datablock.pixels.foreach_set(np.ascontiguousarray(painted[::-1]).ravel())
    np.testing.assert_array_equal(image_of(datablock).pixels, painted)
    datablock.pack()
    np.testing.assert_array_equal(image_of(datablock).pixels, painted)


@pytest.mark.parametrize("names", [["Y"], ["Y", "A"]])
def test_grey(names: list[str], tmp_path: Path) -> None:
    pixels = picture(channels=len(names))
    file = write(tmp_path / "a.exr", pixels, names=names)
    image = image_of(bpy.data.images.load(file))
    np.testing.assert_array_equal(image.pixels[..., :3], np.repeat(pixels[..., :1], 3, axis=2))
    packed = bpy.data.images.load(file, check_existing=False)
    packed.pack()
    np.testing.assert_array_equal(image_of(packed).pixels[..., :3], image.pixels[..., :3])


@pytest.mark.parametrize("packed", [False, True])
def test_a_multilayer_file(packed: bool, tmp_path: Path) -> None:
    pixels = picture(channels=4)
    names = [f"ViewLayer.Combined.{channel}" for channel in "RGBA"] + ["ViewLayer.Depth.Z"]
    file = write(tmp_path / "a.exr", np.concatenate([pixels, pixels[..., :1]], axis=2), names=names)
    datablock = bpy.data.images.load(file)
    if packed:
        datablock.pack()
        os.remove(file)
    np.testing.assert_array_equal(image_of(datablock).pixels, pixels)


def test_a_frame_of_a_sequence(tmp_path: Path) -> None:
    frames = {number: picture() for number in (9, 10, 11)}
    files = [write(tmp_path / f"s2_{number:04d}.exr", pixels) for number, pixels in frames.items()]
    datablock = bpy.data.images.load(files[0])
    datablock.source = "SEQUENCE"
    bpy.context.scene.frame_set(11)
    np.testing.assert_array_equal(image_of(datablock).pixels, frames[11])
    np.testing.assert_array_equal(image_of(datablock, frame=10).pixels, frames[10])
    with pytest.raises(ReadError, match=r"image 's2_0009.exr': no such file") as raised:
        image_of(datablock, frame=12)
    assert raised.value.file == str(tmp_path / "s2_0012.exr")


def test_nan_is_repaired() -> None:
    pixels = np.ones((5, 5, 4), np.float32)
    pixels[2, 2, 0] = np.nan
    said: list[str] = []
    np.testing.assert_array_equal(image_of(made(pixels), note=said.append).pixels, 1)
    assert said == ["1 NaN repaired from their neighbours"]


def test_alpha_modes(tmp_path: Path) -> None:
    pixels = picture()
    datablock = bpy.data.images.load(write(tmp_path / "a.exr", pixels))
    datablock.alpha_mode = "NONE"
    np.testing.assert_array_equal(image_of(datablock).pixels, pixels[..., :3])
    datablock.alpha_mode = "STRAIGHT"
    np.testing.assert_allclose(image_of(datablock).pixels[..., :3], pixels[..., :3] * pixels[..., 3:], rtol=1e-6)


def test_the_last_render() -> None:
    image = image_of(rendered())
    assert (image.type, image.pixels.shape) == ("color", (8, 8, 4))
    assert (image.pixels[..., 3] == 1).all()


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("missing", "image 'x': no such file"),
        ("damaged", "image 'x': not an EXR file"),
        ("unknown", "image 'x': Blender finds no pixels in it"),
        ("tiled", r"image 'x' is a picture of several tiles"),
        ("no picture", r"image 'x': .*(layer|colour|R, G, B)"),
    ],
)
def test_pictures_without_pixels(kind: str, said: str, tmp_path: Path) -> None:
    if kind == "tiled":
        datablock = bpy.data.images.new("x", 4, 4, tiled=True)
    else:
        datablock = bpy.data.images.new("x", 4, 4)
        datablock.source = "FILE"
        datablock.filepath = str(tmp_path / ("a.tga" if kind == "unknown" else "a.exr"))
        if kind in ("damaged", "unknown"):
            Path(datablock.filepath).write_bytes(b"nothing")
        elif kind == "no picture":
            write(tmp_path / "a.exr", picture(channels=3), names=["N.X", "N.Y", "N.Z"])
    with pytest.raises(FlowabsError, match=said):
        image_of(datablock)


# ---------------------------------------------------------------------- to Blender


def test_a_result_is_ready_for_the_compositor() -> None:
    pixels = picture()
    datablock = show(fa.Image.from_array(pixels), "result")
    assert (datablock.is_float, datablock.alpha_mode) == (True, "PREMUL")
    assert datablock.colorspace_settings.name == color_names.working_space_name()
    np.testing.assert_array_equal(held(datablock), pixels)


def test_a_result_is_filled_again_and_nobody_else_s_picture() -> None:
    show(fa.Image.from_array(picture()), "result")
    pixels = picture(height=3, width=4)
    again = show(fa.Image.from_array(pixels), "result")
    np.testing.assert_array_equal(held(again), pixels)
    assert [each.name for each in bpy.data.images] == ["result"]
    mine = made(picture(), name="mine")
    before = held(mine)
    other = show(fa.Image.from_array(pixels), "mine")
    assert other != mine
    np.testing.assert_array_equal(held(mine), before)


def test_types_that_are_no_colour() -> None:
    values = RNG.uniform(0, 1, (4, 6)).astype(np.float32)
    matte = held(show(fa.Image.from_array(values, type="matte"), "matte"))
    np.testing.assert_array_equal(matte, np.stack([values, values, values, np.ones_like(values)], axis=2))
    depth = show(fa.Image.from_array(values * 1e10, type="depth"), "depth")
    assert depth.colorspace_settings.name == "Non-Color"
    np.testing.assert_array_equal(held(depth)[..., 1], values * np.float32(1e10))
    flow = held(show(fa.Image.from_array(np.stack([values, -values], axis=2)), "flow"))
    np.testing.assert_array_equal(flow[..., :2], np.stack([values, -values], axis=2))
    assert (flow[..., 2:] == [0, 1]).all()
    with pytest.raises(FlowabsError, match="four channels, this one has 5"):
        show(fa.Image.from_array(np.zeros((2, 2, 5), np.float32), type="data", channels="abcde"), "data")


def test_another_space_becomes_the_working_space() -> None:
    pixels = picture(channels=3)
    datablock = show(fa.Image.from_array(pixels, "ACEScg"), "result")
    expected = fa.Image.from_array(pixels, "ACEScg").to_array(colorspace="lin_rec709")
    np.testing.assert_array_equal(held(datablock)[..., :3], expected)


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="the working space is Blender 5's")
def test_a_file_of_another_working_space(tmp_path: Path) -> None:
    file = write(tmp_path / "a.exr", picture(channels=3))
    loaded = bpy.data.images.load(file)
    loaded.pack()
    light = image_of(loaded)
    bpy.ops.wm.set_working_color_space(working_space="ACEScg")
    assert color_names.working_space().name == "lin_ap1_scene"
    image = image_of(loaded)
    assert image.colorspace.name == "lin_ap1_scene"
    back = image.to_array(colorspace="lin_rec709")
    np.testing.assert_allclose(back, light.pixels, rtol=5e-3, atol=5e-3)
    np.testing.assert_allclose(held(show(light, "result"))[..., :3], held(loaded)[..., :3], rtol=5e-3, atol=5e-3)
