from pathlib import Path

import numpy as np
import pytest

from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.resize import scale_image, scale_window
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import TYPES
from flowabs_nodes.testing.pictures import make_input
from tests.engine.fakes import picture


def test_windows_shrink_at_their_edges():
    assert scale_window(Window(0, 0, 1920, 1080), 0.5) == (0, 0, 960, 540)
    assert scale_window(Window(-10, 5, 101, 33), 0.5) == (-5, 3, 51, 16)
    assert scale_window(Window(7, 7, 1, 1), 0.1) == (1, 1, 1, 1)


@pytest.mark.parametrize("scale", [0.5, 0.3, 0.77])
@pytest.mark.parametrize("data", [Window(0, 0, 40, 30), Window(6, 4, 20, 18), Window(-9, -5, 60, 44)])
def test_a_picture_keeps_its_place_brightness_and_metadata(scale, data):
    y, x = np.mgrid[data.y : data.y + data.height, data.x : data.x + data.width] + 0.5
    image = Image.from_array(np.stack([x, y, np.full_like(x, 0.5)], axis=2))
    spec = image.spec
    spec.x, spec.y = data.x, data.y
    spec.full_width, spec.full_height = 40, 30
    spec.attribute("owner", "somebody")
    small = scale_image(Image(image.pixels, spec, "color"), scale)
    assert small.display_window == scale_window(Window(0, 0, 40, 30), scale)
    assert small.data_window == scale_window(data, scale)
    assert small.spec.get("owner") == "somebody"
    window = small.data_window
    rows = (np.arange(window.y, window.y + window.height) + 0.5) * 30 / small.display_window.height
    inside = slice(2, -2)
    np.testing.assert_allclose(small.pixels[:, 3, 1][inside], rows[inside], atol=0.05)
    assert (small.pixels[..., 2] == 0.5).all(), "no dark rim"


def test_highlights_make_no_negative_rim_and_opaque_stays_opaque():
    pixels = np.zeros((32, 32, 4), np.float32)
    pixels[8:20, 8:20, :3] = 1000
    pixels[..., 3] = 1
    small = scale_image(Image.from_array(pixels), 0.4)
    assert small.pixels.min() == 0
    assert small.pixels.max() == 1000
    assert (small.pixels[..., 3] == 1).all()


@pytest.mark.parametrize("kind", ["flow", "data"])
def test_directions_and_ids_are_never_mixed(kind):
    rng = np.random.default_rng(1)
    pixels = rng.integers(0, 1000, (20, 30, 2)).astype(np.float32)
    image = Image.from_array(pixels, type=kind)
    small = scale_image(image, 0.5)
    assert small.type == kind
    assert small.channels == image.channels
    assert set(small.pixels[..., 0].ravel()) <= set(pixels[..., 0].ravel())
    np.testing.assert_array_equal(small.pixels, pixels[1::2, 1::2])


@pytest.mark.parametrize("kind", [name for name, declared in TYPES.items() if not declared.filtered])
def test_what_has_no_mean_is_taken_from_the_nearest_pixel(kind):
    image = make_input(kind, "noise", 20, 30)
    assert image.pixels.dtype == TYPES[kind].dtype
    small = scale_image(image, 0.5)
    taken = {tuple(pixel) for pixel in image.pixels.reshape(-1, image.pixels.shape[2])}
    if not TYPES[kind].lengths:
        assert {tuple(pixel) for pixel in small.pixels.reshape(-1, small.pixels.shape[2])} <= taken
    assert small.pixels.dtype == image.pixels.dtype


def test_motion_is_as_much_shorter_as_the_picture():
    motion = Image.from_array(np.full((31, 40, 4), 8.0), type="motion", channels=TYPES["motion"].channels[0])
    small = scale_image(motion, 0.5)
    assert small.display_window == (0, 0, 20, 16)
    np.testing.assert_allclose(small.pixels[3, 4], [4, 8 * 16 / 31, 4, 8 * 16 / 31], rtol=1e-6)


def test_large_ids_are_exact_in_a_smaller_picture():
    ids = np.random.default_rng(2).integers(0, 2**32, (20, 30), np.uint32)
    small = scale_image(Image.from_array(ids, type="id"), 0.5)
    np.testing.assert_array_equal(small.pixels[..., 0], ids[1::2, 1::2])


def test_full_size_is_the_image_itself():
    image = picture()
    assert scale_image(image, 1.0) is image


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (3, 200), (7, 1)])
@pytest.mark.parametrize("scale", [0.01, 0.3, 0.999])
def test_any_shape_at_any_scale(shape, scale):
    image = Image.from_array(np.random.default_rng(1).random((*shape, 3)))
    small = scale_image(image, scale)
    assert small.data_window == small.display_window == scale_window(image.data_window, scale)
    assert image.pixels.min() <= small.pixels.min() <= small.pixels.max() <= image.pixels.max()


def test_lines_of_a_smaller_picture_are_those_of_the_full_one():
    photograph = Path(__file__).parents[1] / "data" / "chelsea_eye.png"
    options = {"set": {"plate.file": str(photograph), "line_width": 2.5}, "outputs": ["lines"]}
    document = load_graph("lines").document
    graph = load_graph({name: value for name, value in document.items() if name != "reference_size"})
    full, half = (graph.run(scale=scale, **options)["lines"] for scale in (1, 0.5))
    ink = 1 - full.pixels.mean()
    assert 1 - half.pixels.mean() == pytest.approx(ink, rel=0.05)
    assert np.abs(scale_image(full, 0.5).pixels - half.pixels).mean() < 0.3 * ink
