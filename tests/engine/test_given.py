"""What is given in place of outputs: images, arrays, ImageBufs."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.engine import load_graph
from flowabs_nodes.errors import ArgumentError, CommandError
from flowabs_nodes.image import Image
from tests.engine.fakes import picture

RGB = np.random.default_rng(4).random((6, 8, 3), np.float32)


class Tensor:
    """An array of another library, which NumPy can read."""

    def __array__(self, dtype=None, copy=None):
        return RGB


@pytest.fixture(scope="module")
def graph():
    nodes = {
        "plate": {"type": "read@1"},
        "z": {"type": "read_depth@1"},
        "near": {"type": "matte@1", "inputs": {"image": "z"}},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "bright": {"type": "exposure@1", "inputs": {"image": "plate", "mask": "near"}, "params": {"stops": 1}},
    }
    return load_graph({"format": "flowabs.graph/1", "nodes": nodes})


@pytest.mark.parametrize(
    "plate", [RGB, RGB.astype(np.float64), RGB[..., ::-1][..., ::-1], Tensor(), picture(), RGB > 2]
)
def test_an_array_is_scene_linear_light(graph, plate):
    out = graph.run(given={"plate": plate}, outputs="plate")["plate"]
    assert (out.type, out.colorspace.name) == ("color", "lin_rec709")
    np.testing.assert_array_equal(out.pixels, np.asarray(plate, np.float32))


def test_rgba_and_grey(graph):
    rgba = np.concatenate([RGB, RGB[..., :1]], axis=2)
    assert graph.run(given={"plate": rgba}, outputs="plate")["plate"].channels == ("R", "G", "B", "A")
    for grey in (RGB[..., 0], RGB[..., :1]):
        plate = graph.run(given={"plate": grey}, outputs="plate")["plate"]
        np.testing.assert_array_equal(plate.pixels, np.repeat(RGB[..., :1], 3, axis=2))


def test_an_array_becomes_what_the_output_is(graph):
    given = {"near": RGB[..., 0], "z": 10 * RGB[..., 0], "flow": RGB[..., :2]}
    out = graph.run(given=given, outputs=["near", "z", "flow"])
    assert [image.type for image in out.values()] == ["matte", "depth", "flow"]
    assert out["z"].channels == ("Z",)


def test_a_node_of_which_one_output_is_given_and_another_needed_says_so():
    nodes = {"ids": {"type": "read_id@1"}, "near": {"type": "matte@1", "inputs": {"image": "ids.coverage"}}}
    graph = load_graph({"format": "flowabs.graph/1", "nodes": nodes})
    with pytest.raises(CommandError, match=r"node ids: .*\(its id is given, but not 'ids.coverage'\)"):
        graph.run(given={"ids": np.ones((6, 8), np.uint32)}, outputs=["ids", "near"])


def test_a_matte_that_is_an_array_masks(graph):
    mask = np.zeros((6, 8), bool)
    mask[:, :4] = True
    out = graph.run(given={"plate": RGB, "near": mask}, outputs="bright")["bright"].pixels
    np.testing.assert_allclose(out[:, :4], 2 * RGB[:, :4], rtol=1e-6)
    np.testing.assert_array_equal(out[:, 4:], RGB[:, 4:])


def test_an_imagebuf_keeps_its_windows(graph):
    spec = oiio.ImageSpec(8, 6, 3, "float")
    spec.x, spec.full_width = 3, 20
    buf = oiio.ImageBuf(spec)
    buf.set_pixels(buf.roi, RGB)
    out = graph.run(given={"plate": buf}, outputs="plate")["plate"]
    assert (out.data_window.x, out.display_window.width) == (3, 20)
    np.testing.assert_array_equal(out.pixels, RGB)


def test_arrays_of_several_frames(graph):
    out = graph.run(2, given={"plate": {1: RGB, 2: 2 * RGB}}, outputs="plate")["plate"]
    np.testing.assert_array_equal(out.pixels, 2 * RGB)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {"plate": np.full((4, 4, 3), 9, np.uint8)},
            r"given\['plate'\]: .*uint8 with white at 255 \(divide by 255, or",
        ),
        ({"plate": np.full((4, 4, 3), 9, np.uint16)}, r'white at 65535 .*Image.from_array\(array, colorspace="sRGB"\)'),
        ({"plate": np.full((4, 4, 3), 200)}, r"expected color with white at 1, found int64 up to 200"),
        ({"near": np.full((4, 4), 200, np.uint8)}, r"given\['near'\]: expected matte .*\(divide by 255\)$"),
        ({"near": RGB}, r"given\['near'\]: expected matte, found color"),
        ({"plate": RGB[..., :2]}, r"given\['plate'\]: expected color, found flow"),
        ({"plate": {1: RGB[0, 0]}}, r"given\['plate'\]\[1\]: expected numbers of shape .*found float32 \(3,\)"),
        ({"plate": np.array(["a"])}, "expected numbers of shape"),
        ({"plate": "plate.exr"}, "expected an Image or an array, found str"),
        ({"plate": None}, "expected an Image or an array, found NoneType"),
        (RGB, "expected a dict such as .*, found ndarray"),
    ],
)
def test_what_is_no_image_is_refused_by_its_name(graph, given, words):
    with pytest.raises(ArgumentError, match=words) as caught:
        graph.run(given=given, outputs="plate")
    assert caught.value.parameter == "given"


def test_an_image_is_not_made_of_an_image():
    with pytest.raises(ArgumentError, match="found an Image"):
        Image.from_array(picture())
