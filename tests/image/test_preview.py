"""The picture of an image in a notebook."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import srgb
from flowabs_nodes.image import Image
from flowabs_nodes.image.preview import LARGEST
from flowabs_nodes.port_types import TYPES, pixel_type


@pytest.fixture
def shown(tmp_path):
    """Return a function that gives the 8-bit pixels (H, W, C) of an image's picture, read by OpenImageIO."""

    def read(image):
        file = tmp_path / "shown.png"
        file.write_bytes(image._repr_png_())
        config = oiio.ImageSpec()
        config["oiio:UnassociatedAlpha"] = 1  # as it is in the file
        buf = oiio.ImageBuf(str(file), 0, 0, config)
        pixels = buf.get_pixels(oiio.UINT8)
        assert not buf.has_error, buf.geterror()
        return np.asarray(pixels).reshape(buf.spec().height, buf.spec().width, -1)

    return read


def test_color_goes_through_srgb_and_clips(shown):
    ramp = np.linspace(-0.2, 1.5, 64, dtype=np.float32)
    rgb = np.stack([ramp, ramp[::-1], ramp * 0.5], axis=1)[None]
    expected = np.rint(srgb.encoded(rgb.clip(0, 1)) * 255)
    np.testing.assert_array_equal(shown(Image.from_array(rgb)), expected)


def test_another_space_is_converted(shown):
    red = np.array([[[0.6131, 0.0702, 0.0206]]])  # Rec.709's red in ACEScg
    np.testing.assert_allclose(shown(Image.from_array(red, "ACEScg"))[0, 0], [255, 0, 0], atol=2)


def test_alpha_stays_and_is_straight(shown):
    pixels = np.array([[[0.25, 0.25, 0.25, 0.5], [0.3, 0.3, 0.3, 0]]])
    np.testing.assert_array_equal(shown(Image.from_array(pixels)), [[[188, 188, 188, 128], [0, 0, 0, 0]]])


def test_a_matte_is_grey_and_not_encoded(shown):
    matte = Image.from_array(np.array([[0, 0.5, 1, 2]]), type="matte")
    np.testing.assert_array_equal(shown(matte)[..., 0], [[0, 128, 255, 255]])


def test_other_types_are_seen_as_views_show_them(shown):
    depth = Image.from_array(np.array([[1.0, 3, 5, 1e10]]), type="depth")
    flow = Image.from_array(np.array([[[1.0, 0], [0, 1]]]), type="flow")
    ids = Image.from_array(np.arange(200, dtype=np.uint32).reshape(10, 20), type="id")
    for image in (depth, flow, ids):
        looked_at = pixel_type(image.type).look_function()(image).codes
        np.testing.assert_array_equal(shown(image), np.rint(looked_at.clip(0, 1) * 255))


def test_large_pictures_become_small_ones(shown):
    x = np.linspace(0, 1, 3000)
    assert shown(Image.from_array(np.broadcast_to(x, (1500, 3000)))).shape == (LARGEST // 2, LARGEST, 3)
    found = shown(Image.from_array(np.repeat(np.indices((2048, 2048)).sum(0) % 2, 3).reshape(2048, 2048, 3)))
    assert (found == 188).all()  # the mean of black and white light
    assert shown(Image.from_array(np.zeros((1, 5000, 3)))).shape == (1, LARGEST, 3)


@pytest.mark.parametrize("value", [0, 1, np.nan, np.inf, -np.inf, 3.4e38, -3.4e38])
@pytest.mark.parametrize("kind", TYPES)
def test_any_value_of_any_type_is_shown(shown, kind, value):
    declared = TYPES[kind]
    if declared.dtype.kind == "u":
        value = int(np.clip(np.nan_to_num(value), 0, 2**32 - 1))
    for shape in ((1, 1), (2, 3)):
        pixels = np.full((*shape, len(declared.typical_channels)), value, declared.dtype)
        pixels[0, 0] = 0
        assert shown(Image.from_array(pixels, type=kind)).shape[:2] == shape
