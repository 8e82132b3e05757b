"""Nodes at a working scale: where blocks lie, what a graph resolves "auto" to. Crops are the compliance suite's."""

import numpy as np
import pytest

from flowabs_nodes import Image, load_graph
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Window
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.working_scale import WORKING_SCALE

NODES = {name: node for name, node in catalogue().items() if WORKING_SCALE.name in node.all_params}


def plate(height=90, width=130, x=0, y=0, seed=0):
    """Return a picture whose display window has its corner at x, y."""
    rows, columns = np.mgrid[:height, :width]
    shapes = (np.hypot(rows - 40, columns - 60) < 30) + 0.3 * (columns > 90)
    grain = np.random.default_rng(seed).normal(0, 0.01, (height, width, 3))
    rgb = (0.2 + 0.3 * shapes[..., None] * [1, 0.6, 0.3] + grain).astype(np.float32)
    image = Image.from_array(rgb, colorspace="lin_rec709")
    spec = image.spec
    spec.x, spec.y, spec.full_x, spec.full_y = x, y, x, y
    return Image(image.pixels, spec, "color", colorspace=image.colorspace)


def run(name, image, **params):
    inputs = {"image": image}
    if "flow" in NODES[name].all_inputs:
        made = call_node(NODES["etf"], Context(), {"image": image}, {"gradient_reference": 16.0})
        inputs["flow"] = made["flow"]
    return next(iter(call_node(NODES[name], Context(), inputs, params).values()))


def test_these_nodes_can_work_smaller():
    assert {"etf", "fdog", "fdog_iterative", "fbl"} <= NODES.keys()
    assert all(node.all_params[WORKING_SCALE.name].default == "full" for node in NODES.values())


@pytest.mark.parametrize("scale", ["1/2", "1/4"])
@pytest.mark.parametrize("name", ["etf", "fdog", "fdog_iterative", "fbl"])
def test_a_data_window_does_not_move_the_blocks(name, scale):
    image = plate()
    params = {"working_scale": scale, **({"gradient_reference": 16.0, "fill": None} if name == "etf" else {})}
    whole = run(name, image, **params)
    for x, y in ((1, 0), (2, 3), (3, 5)):
        cut = image.on_window(Window(x, y, 124 - x, 86 - y))
        part = run(name, cut, **params)
        assert part.data_window == cut.data_window
        assert part.display_window == image.display_window
        if name == "etf":  # the others' flow is another at the edges, as it sees no pixels beyond
            inside = Window(x + 40, y + 40, 40, 10)
            np.testing.assert_array_equal(part.on_window(inside).pixels, whole.on_window(inside).pixels)


@pytest.mark.parametrize("name", ["etf", "fdog", "fdog_iterative", "fbl"])
def test_a_picture_that_lies_elsewhere_is_the_same(name):
    here = run(name, plate(), working_scale="1/2")
    there = run(name, plate(x=-7, y=13), working_scale="1/2")
    assert (there.data_window.x, there.data_window.y) == (-7, 13)
    np.testing.assert_array_equal(there.pixels, here.pixels)


DOCUMENT = {
    "format": "flowabs.graph/1",
    "name": "drawn",
    "reference_size": {"shorter": 22.5},  # four times as long on the plate
    "interface": {"scale": {"type": "enum", "choices": ["full", "auto", "1/2", "1/4"], "default": "auto"}},
    "nodes": {
        "plate": {"type": "read@1", "params": {"file": "plate.exr"}},
        "flow": {
            "type": "etf@1",
            "inputs": {"image": "plate"},
            "params": {"pre_blur": 1, "gradient_reference": 16, "working_scale": {"from": "scale"}},
        },
        "lines": {
            "type": "fdog@1",
            "inputs": {"image": "plate", "flow": "flow"},
            "params": {"contrast": 1, "softness": 4, "rho": 1, "working_scale": {"from": "scale"}},
        },
        "smooth": {
            "type": "fbl@1",
            "inputs": {"image": "plate", "flow": "flow"},
            "params": {"sigma_g": 2, "iterations": 2, "working_scale": {"from": "scale"}},
        },
    },
}


def outputs(word, scale):
    made = load_graph(DOCUMENT).run(
        given={"plate": plate()}, set={"scale": word}, outputs=["flow", "lines", "smooth"], scale=scale
    )
    return [image.pixels for image in made.values()]


@pytest.mark.parametrize(("scale", "word"), [(1.0, "1/2"), (0.5, "full")])
def test_auto_follows_the_lengths_of_the_picture_that_is_filtered(scale, word):
    for auto, expected in zip(outputs("auto", scale), outputs(word, scale), strict=True):
        np.testing.assert_array_equal(auto, expected)
    assert not any(np.array_equal(*pair) for pair in zip(outputs("full", 1.0), outputs("1/2", 1.0), strict=True))


#: Lengths at which the lines are drawn at full size, soft outlines and evidence looked for at half of it.
SMALLER_IN_PARTS = {
    "working_scale": "auto",
    "sigma_m": 1.0,
    "sigma_c": 1.5,
    "color_weight": 1.0,
    "contrast": 0.5,
    "soft_lines": 1.0,
    "soft_reach": 12.0,
    "evidence": 1.0,
}


@pytest.mark.parametrize(
    ("name", "params"),
    [
        ("fdog", {**SMALLER_IN_PARTS, "sigma_c": 3.0}),
        ("fdog_iterative", {**SMALLER_IN_PARTS, "iterations": 2, "pre_blur": 2.4}),
        ("fdog_iterative", {**SMALLER_IN_PARTS, "iterations": 2, "pre_blur": 2.4, "evidence": 0.0}),
    ],
)
def test_a_crop_to_the_region_has_the_bits_of_the_whole(name, params):
    image = plate(height=60, width=420)
    inputs = {"image": image, "flow": call_node(NODES["etf"], Context(), {"image": image}, {})["flow"]}
    whole = call_node(NODES[name], Context(), inputs, params)
    for window in (Window(203, 17, 9, 5), Window(204, 0, 1, 60)):
        regions = NODES[name].region(NODES[name].defaults() | params, window)
        region = regions["image"]
        assert 60 < window.x - region.x < window.x, "some of the picture is beyond"
        left, right = region.x, region.x + region.width
        crop = {each: picture.on_window(Window(left, 0, right - left, 60)) for each, picture in inputs.items()}
        for output, part in call_node(NODES[name], Context(), crop, params).items():
            np.testing.assert_array_equal(part.on_window(window).pixels, whole[output].on_window(window).pixels)
