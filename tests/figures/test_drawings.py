"""The inputs that are drawn by code are what the figures say they are."""

import numpy as np
import pytest

from flowabs_nodes.color import encode_mono
from tools.gallery import drawings
from tools.gallery.measures import ink_components


@pytest.mark.parametrize(
    ("drawing", "count"), [(drawings.dots_on_circle(), 28), (drawings.dots_x(), 29), (drawings.dots_t(), 19)]
)
def test_dots_are_isolated_and_of_radius_3(drawing, count):
    dots = ink_components(drawing / 255)
    assert drawing.shape == (200, 200)
    assert dots.pieces == count
    assert dots.mean_size == pytest.approx(np.pi * 9, rel=0.2)
    assert drawing[[0, -1]].min() == drawing[:, [0, -1]].min() == 255


def test_the_disc_is_that_of_the_figure():
    clean = drawings.disc_in_noise(sigma=0)
    assert (clean.min(), clean.max()) == (90, 160)
    noise = drawings.disc_in_noise(3) - clean
    assert noise.std() == pytest.approx(40, rel=0.02)
    assert abs(noise.mean()) < 1
    np.testing.assert_array_equal(drawings.disc_in_noise(3), drawings.disc_in_noise(3))
    assert (drawings.disc_in_noise(3) != drawings.disc_in_noise(4)).all()
    assert drawings.disc_contour().sum() == pytest.approx(2 * np.pi * 60, rel=0.02)


def test_a_plate_has_the_code_values_of_its_drawing():
    drawing = drawings.disc_in_noise()
    plate = drawings.scene_linear(drawing)
    assert plate.dtype == np.float32
    np.testing.assert_allclose(encode_mono(plate, "lab", "lin_rec709"), drawing, atol=0.01)


def test_damage():
    photo = np.full((60, 80, 3), 128, np.uint8)
    photo[20:40, 30:60] = (200, 90, 40)
    noisy = drawings.noisy(photo)
    assert noisy.dtype == np.uint8
    assert (noisy.astype(float) - photo).std() == pytest.approx(20, rel=0.03)
    np.testing.assert_array_equal(noisy, drawings.noisy(photo))

    def error(quality):
        return np.abs(drawings.jpeg_damaged(noisy, quality).astype(float) - noisy).mean()

    assert error(10) > error(50) > error(95) > 0
