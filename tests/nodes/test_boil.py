"""The node boil in a graph: by the number of the frame, and without a flow where it does nothing."""

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes import filters
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.boil import BOIL
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.testing.pictures import make_input

LINES, FLOW = (make_input(kind, "shapes", 40, 50) for kind in ("matte", "flow"))
PLATE = make_input("color", "shapes", 40, 50)

GRAPH = {
    "format": "flowabs.graph/1",
    "nodes": {
        "plate": {"type": "read@1"},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "lines": {"type": "fdog@1", "inputs": {"image": "plate", "flow": "flow"}},
        "boil": {
            "type": "boil@1",
            "inputs": {"lines": "lines", "flow": "flow"},
            "params": {"amount": 2.0, "hold": 2, "size": 12.0},
        },
        "out": {"type": "write@1", "inputs": {"image": "boil"}, "params": {"file": "out.####.exr"}},
    },
}


def boiled(frame, **inputs):
    images = {"lines": LINES, "flow": FLOW, **inputs}
    return call_node(BOIL, Context(frame=frame), images, {"amount": 2.0, "size": 12.0})["lines"]


def test_the_field_goes_by_the_frame_and_the_display_window():
    x, y = (data - full for data, full in zip(LINES.data_window[:2], LINES.display_window[:2], strict=True))
    expected = filters.boil(LINES.pixels[..., 0], FLOW.pixels, 2.0, 2, 12.0, 1, 5, (x, y))
    np.testing.assert_array_equal(boiled(5).pixels[..., 0], expected)
    moved = [Image(each.pixels, shifted(each.spec), each.type) for each in (LINES, FLOW)]
    np.testing.assert_array_equal(boiled(5, lines=moved[0], flow=moved[1]).pixels, boiled(5).pixels)


def shifted(spec):
    """Return a header with both windows moved: the same place in the picture."""
    spec.x, spec.y, spec.full_x, spec.full_y = spec.x + 7, spec.y - 11, spec.full_x + 7, spec.full_y - 11
    return spec


def test_a_still_picture_boils_in_any_order():
    graph = fa.load_graph(GRAPH)
    plate = {"plate": PLATE}
    runs = [
        {frame: graph.run(frame, given=plate, outputs=["boil"])["boil"].pixels for frame in order}
        for order in ((1, 2, 3, 4), (4, 2, 3, 1))
    ]
    session = fa.Session(GRAPH)
    session.given(plate)
    runs.append({frame: session.run("boil", frame=frame)["boil"].pixels for frame in (3, 1, 4, 2)})
    for run in runs:
        for frame, pixels in run.items():
            np.testing.assert_array_equal(pixels, runs[0][frame])
    np.testing.assert_array_equal(runs[0][1], runs[0][2])
    assert (runs[0][2] != runs[0][3]).mean() > 0.05


def test_without_an_amount_the_lines_come_through_and_no_flow_is_made():
    events = []
    graph = fa.load_graph(GRAPH)
    given = {"lines": LINES, "plate": PLATE}
    found = graph.run(1, given=given, set={"boil.amount": 0.0}, outputs=["boil"], on_event=events.append)
    np.testing.assert_array_equal(found["boil"].pixels, LINES.pixels)
    assert not any(event.get("node") == "flow" for event in events)
    graph.run(1, given=given, outputs=["boil"], on_event=events.append)
    assert any(event.get("node") == "flow" for event in events)


@pytest.mark.parametrize("amount", [0.0, 2.0])
def test_a_mask_says_where(amount):
    mask = LINES.with_pixels(np.indices((40, 50))[1] < 25, "matte")
    images = {"lines": LINES, "flow": FLOW, "mask": mask}
    found = call_node(BOIL, Context(), images, {"amount": amount, "size": 12.0})["lines"].pixels
    np.testing.assert_array_equal(found[:, 25:], LINES.pixels[:, 25:])
    if amount:
        np.testing.assert_array_equal(found[:, :25], boiled(1).pixels[:, :25])
