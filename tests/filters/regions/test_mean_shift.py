import sys

import cv2
import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters import mean_shift, measure_clipping
from flowabs_nodes.filters.regions.merge import flatten_regions
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.baselines import MEAN_SHIFT
from flowabs_nodes.nodes.declare import Context
from tests.filters.flows import THIN
from tests.filters.pictures import photo


def eye():
    """The cat's eye as code values of Lab."""
    lab = cv2.cvtColor(photo().astype(np.uint8), cv2.COLOR_RGB2LAB).astype(np.float32)
    return (lab - np.float32([0, 128, 128])) * np.float32([1, 2.55, 2.55])


def to_8_bit(codes):
    return np.rint(codes / [1, 2.55, 2.55] + [0, 128, 128]).astype(np.uint8)


@pytest.mark.parametrize(("spatial", "range"), [(10, 5), (3, 20), (0, 5)])
def test_without_regions_it_is_opencvs(spatial, range):
    codes = eye()
    expected = cv2.pyrMeanShiftFiltering(to_8_bit(codes), spatial, range, maxLevel=0, termcrit=(3, 100, 0.1))
    found = mean_shift(codes, spatial, range, min_region=0)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found / [1, 2.55, 2.55] + [0, 128, 128], expected, rtol=0, atol=1e-4)


def regions(image, limit):
    """Sizes of the regions by flood fill, each with its pixels."""
    height, width, _ = image.shape
    left, found = {(y, x) for y in range(height) for x in range(width)}, []
    while left:
        grown, rim = [], [left.pop()]
        while rim:
            y, x = rim.pop()
            grown.append((y, x))
            for there in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
                if there in left and np.linalg.norm(image[there] - image[y, x]) <= limit:
                    left.remove(there)
                    rim.append(there)
        found.append(grown)
    return found


def test_regions_are_flat_and_none_is_small():
    units = np.float32([1, 1 / 2.55, 1 / 2.55])
    modes = mean_shift(eye(), min_region=0)
    unjoined, segmented = mean_shift(eye(), min_region=1), mean_shift(eye(), min_region=20)
    for region in regions(modes * units, 2.5):
        pixels = tuple(np.transpose(region))
        np.testing.assert_allclose(
            unjoined[pixels], np.broadcast_to(modes[pixels].mean(0), (len(region), 3)), atol=1e-3
        )
    assert min(len(region) for region in regions(unjoined, 0)) < 20 <= min(map(len, regions(segmented, 0)))


def joined(rows, limit=0.5, min_region=2, there=None):
    image = np.repeat(np.float32(rows)[..., None], 3, axis=2)
    flatten_regions(image, np.ones(image.shape[:2], bool) if there is None else there, limit, min_region)
    return image[..., 0]


def test_a_small_region_joins_the_neighbour_nearest_in_colour():
    np.testing.assert_array_equal(joined([[1, 1, 7, 10, 10]]), [[1, 1, 9, 9, 9]])
    np.testing.assert_array_equal(joined([[1, 1, 4, 9, 9]]), [[2, 2, 2, 9, 9]])
    np.testing.assert_array_equal(joined([[1, 1, 4, 9, 9]], min_region=1), [[1, 1, 4, 9, 9]])
    there = np.array([[1, 1, 1, 0, 0]], bool)
    np.testing.assert_array_equal(joined([[1, 1, 7, 9, 8]], there=there), [[3, 3, 3, 9, 8]])


def test_pixels_are_of_one_region_where_their_colours_differ_by_the_limit_at_most():
    far = 3**0.5  # between two greys one apart
    np.testing.assert_array_equal(joined([[1, 3, 8]], limit=2.01 * far, min_region=1), [[2, 2, 8]])
    np.testing.assert_array_equal(joined([[1, 3, 8]], limit=1.99 * far, min_region=1), [[1, 3, 8]])
    np.testing.assert_array_equal(joined([[1, 9], [9, 1]], min_region=1), [[1, 9], [9, 1]])  # corners do not touch


def test_small_regions_join_each_other_until_none_is_small():
    np.testing.assert_array_equal(joined([[0, 2, 50, 54]]), [[1, 1, 52, 52]])
    np.testing.assert_array_equal(joined([[0, 0, 0, 10, 18, 25]], min_region=4), [[np.float32(53 / 6)] * 6])
    np.testing.assert_array_equal(joined([[3, 7, 8]], min_region=100), [[6, 6, 6]])


def test_pixels_without_alpha_keep_their_value():
    codes, alpha = eye(), np.ones((64, 64))
    alpha[20:40, 30:33] = 0
    codes[alpha == 0] = 1000
    found = mean_shift(codes, alpha=alpha)
    np.testing.assert_array_equal(found[alpha == 0], codes[alpha == 0])
    assert found[alpha > 0].max() < 256


def test_what_is_beyond_8_bits_is_clipped_and_counted():
    codes = np.zeros((8, 8, 3), np.float32)
    codes[..., 0] = 100
    assert measure_clipping(codes) == 0
    codes[:2, :, 0], codes[3:5, :, 1], codes[6, :3, 2], codes[7, :, 0] = 400, 350, -340, -3
    assert measure_clipping(codes) == 16 + 16 + 3 + 8
    found = mean_shift(codes, min_region=0)
    assert found[0, 0, 0] == 255
    np.testing.assert_allclose(found[3, 0, 1], 127 * 2.55)


def test_the_node_says_how_many_pixels_were_clipped():
    notes = []
    pixels = np.full((6, 5, 3), 0.5, np.float32)
    context = Context(note=notes.append)
    MEAN_SHIFT.run(context, Image.from_array(pixels), spatial=2.0, range=5.0, min_region=0)
    assert notes == []
    pixels[0, :3] = 8
    MEAN_SHIFT.run(context, Image.from_array(pixels), spatial=2.0, range=5.0, min_region=0)
    assert len(notes) == 1
    assert "3 pixels" in notes[0]


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    codes = np.random.default_rng(1).uniform(0, 255, (*shape, 3))
    assert np.isfinite(mean_shift(codes)).all()


def test_every_number_of_threads_gives_the_same_bits(each_thread_count):
    one, *others = each_thread_count(lambda: mean_shift(eye()))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_without_opencv_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(FlowabsError, match=r"mean_shift needs OpenCV.*pip install 'flowabs-nodes\[compare\]'"):
        mean_shift(np.zeros((3, 3, 3)))


@pytest.mark.parametrize(
    ("arguments", "parameter"),
    [
        ({"codes": np.zeros((2, 2))}, "codes"),
        ({"spatial": -1}, "spatial"),
        ({"range": 300}, "range"),
        ({"min_region": 1.5}, "min_region"),
        ({"alpha": np.ones((3, 2))}, "alpha"),
    ],
)
def test_errors_name_the_argument(arguments, parameter):
    with pytest.raises(ArgumentError, match=parameter) as error:
        mean_shift(**({"codes": np.zeros((2, 2, 3))} | arguments))
    assert error.value.parameter == parameter
