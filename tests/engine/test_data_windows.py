"""Data windows of a node's inputs: their union, what is beyond them, and inputs that may be cut."""

from dataclasses import replace

import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.data_windows import on_display, on_union, with_alpha
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import Context, Node, Port
from tests.comp.pictures import at, noise, rgba


def test_the_union_holds_every_pixel_and_is_transparent_elsewhere():
    images = {"one": at(Image.from_array(rgba(2, 3)), 0, 0), "other": at(Image.from_array(noise(2, 2, 3)), 4, 3)}
    found = on_union(images)
    assert {image.data_window for image in found.values()} == {Window(0, 0, 6, 5)}
    for name, image in images.items():
        np.testing.assert_array_equal(found[name].on_window(image.data_window).pixels, with_alpha(image).pixels)
    assert found["other"].pixels[0, 0].tolist() == [0, 0, 0, 0]
    assert found["other"].pixels[-1, -1, 3] == 1


def test_on_one_window_images_stay_the_same_objects():
    image = at(Image.from_array(noise(2, 2, 3)), 1, 1)
    assert on_union({"one": image, "other": image})["other"] is image


def test_beyond_a_depth_is_the_background():
    depths = {name: at(Image.from_array(np.ones((2, 2)), type="depth"), x, 0) for name, x in (("a", 0), ("b", 2))}
    np.testing.assert_array_equal(on_union(depths)["a"].pixels[0, :, 0], np.float32([1, 1, 1e10, 1e10]))


def test_alpha_is_added_to_colours_alone():
    for image in (Image.from_array(noise(2, 2)), Image.from_array(rgba(2, 2)), Image.from_array(noise(2, 2, 2))):
        assert with_alpha(image) is image
    assert with_alpha(Image.from_array(noise(2, 2, 3))).channels == ("R", "G", "B", "A")


ADDED = Node(
    "added",
    1,
    ".",
    (Port("image", "color", "."), Port("other", "mono", ".", optional=True, cut=True)),
    (Port("image", "=image", "."),),
    (),
    lambda context, image, other: image.with_pixels(image.pixels + other.pixels),
)


def test_an_input_that_may_be_cut_is_brought_to_the_first_ones_window():
    image, other = at(Image.from_array(np.zeros((3, 3, 3))), 2, 2), at(Image.from_array(np.ones((4, 4))), 3, 0)
    result = call_node(ADDED, Context(), {"image": image, "other": other}, {})["image"]
    np.testing.assert_array_equal(result.pixels[..., 0], [[0, 1, 1], [0, 1, 1], [0, 0, 0]])
    strict = replace(ADDED, inputs=(ADDED.inputs[0], replace(ADDED.inputs[1], cut=False)))
    with pytest.raises(FlowabsError, match="input 'other' has the data window 4x4"):
        call_node(strict, Context(), {"image": image, "other": other}, {})


def test_one_of_a_picture_of_another_size_is_refused():
    image, other = Image.from_array(np.zeros((3, 3, 3))), Image.from_array(np.ones((4, 4)))
    with pytest.raises(FlowabsError, match="input 'other' is of a picture of 4x4, but input 'image' of 3x3"):
        call_node(ADDED, Context(), {"image": image, "other": other}, {})


def test_a_matte_reaches_its_display_window_and_a_picture_stays():
    matte = at(Image.from_array(np.ones((2, 3)), type="matte"), -1, 2, 8, 6)
    assert on_display(matte).data_window == Window(-1, 0, 9, 6)
    assert on_display(matte).pixels.sum() == 6
    for kind, pixels in (("color", rgba()), ("depth", np.ones((2, 2)))):
        image = at(Image.from_array(pixels, type=kind), 1, 1)
        assert on_display(image) is image


def test_an_input_with_more_pixels_is_cut_to_the_first_ones():
    """An inverted matte reaches its display window, and goes where the matte went."""
    strict = replace(ADDED, inputs=(ADDED.inputs[0], replace(ADDED.inputs[1], cut=False)))
    image, other = at(Image.from_array(np.zeros((2, 2, 3))), 3, 1), at(Image.from_array(noise(16, 20)), 0, 0)
    result = call_node(strict, Context(), {"image": image, "other": other}, {})["image"]
    np.testing.assert_array_equal(result.pixels[..., :1], other.pixels[1:3, 3:5])
    proxy = at(Image.from_array(noise(16, 20)), 0, 0, 40, 32)
    with pytest.raises(FlowabsError, match="input 'other' has the data window 20x16"):
        call_node(strict, Context(), {"image": image, "other": proxy}, {})
