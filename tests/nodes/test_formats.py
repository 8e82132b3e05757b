"""Constant, crop and reformat in graphs: windows, what lengths make of them, and values that are refused."""

import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.engine import load_graph
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.formats import CONSTANT, CROP, REFORMAT
from tests.comp.pictures import at, noise, rgba, run


def chain(*steps, reference=None):
    """Return a graph of a plate and nodes one after another, each (name, type, parameters)."""
    nodes, before = {"plate": {"type": "read@1"}}, "plate"
    for name, type, params in steps:
        nodes[name] = {"type": type, "inputs": {"image": before}, "params": params}
        before = name
    document = {"format": "flowabs.graph/1", "nodes": nodes}
    return load_graph(document | ({"reference_size": {"shorter": reference}} if reference else {}))


# ---------------------------------------------------------------------- constant


def test_constant_of_a_size_and_like_an_image():
    alone = run(CONSTANT, {}, color=(0.1, 2, -1), size=[7, 5])
    assert (alone.data_window, alone.display_window) == (Window(0, 0, 7, 5), Window(0, 0, 7, 5))
    np.testing.assert_array_equal(alone.pixels, np.broadcast_to(np.float32([0.1, 2, -1]), (5, 7, 3)))
    plate = at(Image.from_array(rgba(), "lin_ap1_scene"), -3, 4)
    like = run(CONSTANT, {"like": plate}, color=(1, 1, 1))
    assert (like.data_window, like.display_window) == (plate.data_window, plate.display_window)
    assert (like.channels, like.colorspace) == (("R", "G", "B"), plate.colorspace)


def test_constant_follows_the_scale_of_the_run():
    document = {
        "format": "flowabs.graph/1",
        "reference_size": {"shorter": 100},
        "nodes": {"grey": {"type": "constant@1", "params": {"size": [31, 20]}}},
    }
    for scale, size in ((1, (31, 20)), (0.5, (16, 10)), (0.01, (1, 1))):
        image = load_graph(document).run(outputs="grey", scale=scale)["grey"]
        assert image.display_window == (0, 0, *size)


# ---------------------------------------------------------------------- crop


@pytest.mark.parametrize(
    ("box", "window"),
    [
        (None, Window(2, 3, 7, 5)),
        ([-100, -100, 100, 100], Window(2, 3, 7, 5)),
        ([4, 4, 6, 7], Window(4, 4, 2, 3)),
        ([0, 0, 4, 5], Window(2, 3, 2, 2)),
        ([3.4, 3.5, 5.6, 4.5], Window(3, 4, 3, 1)),
    ],
)
def test_crop_cuts_the_data_window_and_keeps_the_display_window(box, window):
    image = at(Image.from_array(rgba(5, 7)), 2, 3)
    result = run(CROP, {"image": image}, box=box)
    assert (result.data_window, result.display_window) == (window, image.display_window)
    np.testing.assert_array_equal(result.pixels, image.on_window(window).pixels)


def test_a_box_beside_the_picture_leaves_one_empty_pixel_and_says_so():
    warnings = []
    image = at(Image.from_array(rgba()), 2, 3)
    result = call_node(CROP, Context(warn=warnings.append), {"image": image}, {"box": [15, 12, 18, 14]})["image"]
    assert result.data_window == Window(15, 12, 1, 1)
    assert not result.pixels.any()
    assert "has no pixel of the data window" in warnings[0]


def test_a_box_grows_with_the_plate_like_every_length():
    plate = Image.from_array(noise(100, 200, 3))
    for reference, scale, window in (
        (None, 1, Window(10, 20, 40, 30)),
        (50, 1, Window(20, 40, 80, 60)),
        (None, 0.5, Window(5, 10, 20, 15)),
        (50, 0.5, Window(10, 20, 40, 30)),
    ):
        loaded = chain(("cut", "crop@1", {"box": [10, 20, 50, 50]}), reference=reference)
        assert loaded.run(given={"plate": plate}, outputs="cut", scale=scale)["cut"].data_window == window


def test_crop_changes_no_length_after_it():
    """The display window is what lengths go by, and it stays."""
    plate = Image.from_array(noise(100, 200, 3))
    plain = chain(("soft", "blur@1", {"sigma": 2}), reference=50).run(given={"plate": plate}, outputs="soft")["soft"]
    cropped = chain(("cut", "crop@1", {"box": [0, 0, 80, 50]}), ("soft", "blur@1", {"sigma": 2}), reference=50)
    soft = cropped.run(given={"plate": plate}, outputs="soft")["soft"]
    inside = Window(0, 0, 100, 60)  # sigma is 4 px: the cut at 160 is farther away
    np.testing.assert_array_equal(soft.on_window(inside).pixels, plain.on_window(inside).pixels)


# ---------------------------------------------------------------------- reformat


def test_a_reformat_in_the_middle():
    """Its size is that of the picture, and lengths after it go by the new format."""
    plate = Image.from_array(noise(80, 160, 3))
    steps = (("small", "reformat@1", {"size": [80, 40]}), ("soft", "blur@1", {"sigma": 3}))
    images = chain(*steps, reference=40).run(given={"plate": plate}, outputs=["small", "soft"])
    assert images["small"].display_window == Window(0, 0, 80, 40)
    alone = chain(("soft", "blur@1", {"sigma": 3})).run(given={"plate": images["small"]}, outputs="soft")["soft"]
    np.testing.assert_array_equal(images["soft"].pixels, alone.pixels)


def test_a_reformat_follows_the_scale_of_the_run():
    plate = Image.from_array(noise(80, 160, 3))
    loaded = chain(("small", "reformat@1", {"size": [81, 40]}), reference=20)
    for scale, size in ((1, (81, 40)), (0.5, (41, 20))):
        image = loaded.run(given={"plate": plate}, outputs="small", scale=scale)["small"]
        assert image.display_window == (0, 0, *size)


def test_a_reformat_lets_two_sizes_meet():
    document = {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1"},
            "logo": {"type": "read@1"},
            "fits": {"type": "reformat@1", "inputs": {"image": "logo"}, "params": {"size": [40, 20]}},
            "comp": {"type": "merge@1", "inputs": {"A": "fits", "B": "plate"}},
        },
    }
    plate, logo = Image.from_array(np.ones((20, 40, 3))), Image.from_array(np.full((10, 10, 3), 0.5))
    comp = load_graph(document).run(given={"plate": plate, "logo": logo}, outputs="comp")["comp"].pixels
    np.testing.assert_allclose(comp[:, 10:30, :3], 0.5, rtol=1e-6)
    np.testing.assert_array_equal(comp[:, :10, :3], 1)
    np.testing.assert_array_equal(comp[..., 3], 1)


# ---------------------------------------------------------------------- values


@pytest.mark.parametrize(
    "size", [[0, 5], [5], [5, 5, 5], [5.0, 5], ["5", 5], [True, 5], [65536, 1], [65535, 65535], 5, None]
)
@pytest.mark.parametrize("node", [CONSTANT, REFORMAT], ids=lambda node: node.type)
def test_sizes_that_are_refused(node, size):
    code, expected = next(param for param in node.params if param.name == "size").problem(size)
    assert code == "bad-value"
    assert expected.startswith("the width and height of a picture")


@pytest.mark.parametrize(
    "box", [[0, 0, 0, 5], [0, 5, 5, 5], [0, 0, 5], "640x480", [0, 0, float("inf"), 5], [True, 0, 5, 5]]
)
def test_boxes_that_are_refused(box):
    (param,) = CROP.params
    assert param.problem(box)[1].startswith("left, top, right and bottom")


def test_check_says_what_a_box_is():
    document = {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1"},
            "cut": {"type": "crop@1", "inputs": {"image": "plate"}, "params": {"box": [5, 0, 1, 1]}},
        },
    }
    (problem,) = graph.check(document)
    assert (problem.code, problem.pointer) == ("bad-value", "/nodes/cut/params/box")
