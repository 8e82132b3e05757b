"""Invert and grade as nodes: data windows and masks. Their formulas are in tests/comp."""

import numpy as np

from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.grade import GRADE, INVERT
from tests.comp.pictures import at, rgba, run


def test_an_inverted_matte_is_1_where_it_had_no_pixels():
    matte = at(Image.from_array(np.full((2, 3), 0.25), type="matte"), 4, 2, 12, 8)
    result = run(INVERT, {"image": matte})
    assert (result.data_window, result.display_window) == (Window(0, 0, 12, 8), matte.display_window)
    assert (result.on_window(matte.data_window).pixels == 0.75).all()
    assert result.pixels.sum() == 12 * 8 - 6 + 6 * 0.75
    np.testing.assert_array_equal(run(INVERT, {"image": result}).on_window(matte.data_window).pixels, matte.pixels)


def test_so_it_masks_all_of_the_other_part():
    matte = at(Image.from_array(np.ones((2, 3)), type="matte"), 4, 2, 12, 8)
    plate = Image.from_array(np.full((8, 12, 3), 0.5))
    outside = run(INVERT, {"image": matte})
    graded = run(GRADE, {"image": plate, "mask": outside}, gain=4.0)
    assert (graded.on_window(matte.data_window).pixels == 0.5).all()
    assert graded.pixels.mean() == (6 * 0.5 + 90 * 2) / 96


def test_mask_and_mix_of_an_inverted_matte():
    matte = at(Image.from_array(np.full((2, 3), 0.25), type="matte"), 4, 2, 12, 8)
    part = at(Image.from_array(np.ones((1, 1)), type="matte"), 4, 2, 12, 8)
    result = run(INVERT, {"image": matte, "mask": part}, mix=0.5)
    assert result.on_window(Window(4, 2, 1, 1)).pixels == 0.5
    assert result.on_window(Window(5, 2, 1, 1)).pixels == 0.25
    assert result.on_window(Window(0, 0, 1, 1)).pixels == 0


def test_a_picture_keeps_its_window():
    image = at(Image.from_array(rgba()), 4, 2)
    assert run(INVERT, {"image": image}).data_window == image.data_window
