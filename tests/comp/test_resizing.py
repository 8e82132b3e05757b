"""Formats: where a picture lies in another one, and what its pixels become. ``--scale`` is in tests/engine."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.choices import FITS, RESIZE_FILTERS
from flowabs_nodes.comp.resizing import fitted
from flowabs_nodes.image import Image, Window
from tests.comp.pictures import at, noise


def ramp(width=40, height=20, channels=3):
    """Return a picture whose values are x and y of its display window, from 0 to 1."""
    y, x = np.mgrid[0:height, 0:width] + 0.5
    parts = [x / width, y / height, np.full_like(x, 0.5), np.ones_like(x)]
    return Image.from_array(np.stack(parts[:channels], axis=2))


@pytest.mark.parametrize(
    ("fit", "data"),
    [
        ("letterbox", Window(0, 15, 60, 30)),
        ("width", Window(0, 15, 60, 30)),
        ("height", Window(-30, 0, 120, 60)),
        ("distort", Window(0, 0, 60, 60)),
    ],
)
def test_where_the_picture_lies(fit, data):
    result = fitted(ramp(), 60, 60, fit, "triangle")
    assert result.display_window == Window(0, 0, 60, 60)
    assert result.data_window == data
    shares = (np.arange(data.width) + 0.5) / data.width
    np.testing.assert_allclose(result.pixels[data.height // 2, 3:-3, 0], shares[3:-3], atol=0.01)


def test_letterbox_is_where_openimageio_fits_it():
    image = ramp(41, 23)
    buf = oiio.ImageBufAlgo.fit(image.to_imagebuf(), "triangle", 0.0, "letterbox", False, oiio.ROI(0, 64, 0, 64))
    data = fitted(image, 64, 64, "letterbox", "triangle").data_window
    rows = np.asarray(buf.get_pixels(oiio.FLOAT))
    assert data.width == 64
    assert abs(data.height - int((rows[..., 2] > 0.25).any(axis=1).sum())) <= 1


def test_every_filter_is_openimageios_and_keeps_grey():
    known = oiio.get_string_attribute("filter_list").split(";")
    assert set(RESIZE_FILTERS) <= set(known)
    grey = Image.from_array(np.full((9, 11, 3), 0.25, np.float32))
    for name in RESIZE_FILTERS:
        for size in ((5, 4), (30, 24)):
            np.testing.assert_allclose(fitted(grey, *size, "distort", name).pixels, 0.25, rtol=1e-5)


def test_the_same_size_changes_no_bit():
    for image in (ramp(), at(ramp(7, 5), 4, 3, 40, 20)):
        result = fitted(image, 40, 20, "letterbox", "lanczos3")
        np.testing.assert_array_equal(result.pixels, image.pixels)
        assert (result.data_window, result.display_window) == (image.data_window, Window(0, 0, 40, 20))


def test_offset_windows_go_along():
    image = at(ramp(20, 10), 10, 4, 40, 20)
    assert fitted(image, 80, 40, "letterbox", "box").data_window == Window(20, 8, 40, 20)
    far = image.spec  # the same picture, whose display window begins elsewhere
    far.x, far.y, far.full_x, far.full_y = 110, 54, 100, 50
    assert fitted(Image(image.pixels, far, "color"), 80, 40, "letterbox", "box").data_window == Window(20, 8, 40, 20)


@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize("size", [(1, 1), (1, 9), (300, 2)])
def test_tiny_pictures(fit, size):
    for image in (ramp(1, 1), ramp(7, 1), ramp(1, 7, 4)):
        result = fitted(image, *size, fit, "lanczos3")
        assert np.isfinite(result.pixels).all()
        assert result.display_window == (0, 0, *size)


def test_mattes_and_alpha_stay_within_0_and_1_and_light_does_not_have_to():
    edge = np.repeat(np.repeat(np.float32([[0, 0, 1, 1, 0, 0]]), 6, axis=0)[..., None], 4, axis=2)
    matte = fitted(Image.from_array(edge[..., :1], type="matte"), 40, 40, "distort", "lanczos3").pixels
    assert 0 <= matte.min() <= matte.max() <= 1
    picture = fitted(Image.from_array(edge), 40, 40, "distort", "lanczos3").pixels
    assert 0 <= picture[..., 3].min() <= picture[..., 3].max() <= 1
    assert picture[..., 0].min() < 0, "OpenImageIO's own overshoot"


def test_the_default_filter_makes_no_rim_beside_a_highlight():
    light = np.full((20, 20, 3), 0.01, np.float32)
    light[8:12, 8:12] = 100
    for size in (13, 47):
        assert fitted(Image.from_array(light), size, size, "distort", "blackman-harris").pixels.min() > 0.009


def test_ids_are_never_mixed_and_motion_grows():
    ids = Image.from_array(np.random.default_rng(1).integers(0, 2**32, (6, 8), np.uint32), type="id")
    result = fitted(ids, 19, 11, "distort", "box")
    assert set(np.unique(result.pixels)) <= set(np.unique(ids.pixels))
    motion = Image.from_array(noise(6, 8, 4), type="motion")
    np.testing.assert_allclose(
        fitted(motion, 16, 18, "distort", "box").pixels[1, 1], motion.pixels[0, 0] * [2, 3, 2, 3]
    )
