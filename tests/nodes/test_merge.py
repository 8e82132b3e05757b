"""Merge as a node: data windows, masks, types in graphs, and what is refused. Its formulas are in tests/comp."""

import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.engine import load_graph
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph.problems import GraphError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.merge import MERGE
from tests.comp.pictures import at, noise, rgba, run


def test_the_result_is_on_the_union_of_data_windows_in_b_s_display_window():
    a, b = at(Image.from_array(noise(4, 5, 3, seed=1)), 3, -2), at(Image.from_array(noise(6, 4, 3, seed=2)), -1, 1)
    spec = b.spec
    spec.attribute("owner", "B")
    b = Image(b.pixels, spec, "color")
    result = run(MERGE, {"A": a, "B": b})
    assert result.data_window == Window(-1, -2, 9, 9)
    assert result.display_window == b.display_window
    assert result.spec.get("owner") == "B"
    np.testing.assert_array_equal(result.on_window(a.data_window).pixels[..., :3], a.pixels)
    np.testing.assert_array_equal(result.on_window(Window(-1, 2, 4, 5)).pixels[..., :3], b.pixels[1:])
    np.testing.assert_array_equal(result.on_window(Window(7, 6, 1, 1)).pixels, [[[0] * 4]])  # of neither


def test_pictures_without_alpha_need_none_on_one_window():
    image = at(Image.from_array(noise(4, 5, 3)), 3, 2)
    assert run(MERGE, {"A": image, "B": image}).channels == ("R", "G", "B")


def test_another_size_of_display_window_is_an_error():
    a, b = at(Image.from_array(rgba()), 0, 0, 20, 16), at(Image.from_array(rgba()), 0, 0, 40, 32)
    with pytest.raises(FlowabsError, match="input 'A' is of a picture of 20x16, but input 'B' of 40x32") as failure:
        run(MERGE, {"A": a, "B": b})
    assert failure.value.code == "window-mismatch"
    assert "reformat" in failure.value.hint


@pytest.mark.parametrize("operation", ["over", "minus", "mask"])
def test_mask_and_mix_lay_the_result_over_b(operation):
    a, b = Image.from_array(rgba(seed=1)), Image.from_array(noise(5, 7, 3, seed=2))
    full = run(MERGE, {"A": a, "B": b}, operation=operation).pixels
    mask = np.random.default_rng(5).random((5, 7), np.float32)
    opaque = np.concatenate([b.pixels, np.ones((5, 7, 1), np.float32)], axis=2)
    inputs = {"A": a, "B": b, "mask": Image.from_array(mask, type="matte")}
    k = mask[..., None] * np.float32(0.5)
    expected = full * k + opaque * (1 - k)
    np.testing.assert_allclose(run(MERGE, inputs, operation=operation, mix=0.5).pixels, expected, rtol=1e-6, atol=1e-6)
    np.testing.assert_array_equal(run(MERGE, {"A": a, "B": b}, operation=operation, mix=0).pixels, opaque)


def test_a_mask_covers_the_union():
    """Outside of its data window a mask is 0, so B stands there, and nothing where there is no B."""
    a, b = at(Image.from_array(rgba(4, 4)), 0, 0), at(Image.from_array(rgba(4, 4, seed=2)), 4, 0)
    mask = at(Image.from_array(np.ones((2, 2)), type="matte"), 1, 1)
    result = run(MERGE, {"A": a, "B": b, "mask": mask})
    np.testing.assert_array_equal(result.on_window(b.data_window).pixels, b.pixels)
    np.testing.assert_array_equal(result.on_window(Window(1, 1, 2, 2)).pixels, a.pixels[1:3, 1:3])
    np.testing.assert_array_equal(result.on_window(Window(0, 0, 1, 1)).pixels, [[[0] * 4]])


def test_one_pixel():
    a, b = Image.from_array(np.float32([[[0.5, 0, 0, 0.5]]])), Image.from_array(np.float32([[[0, 1, 0, 1]]]))
    np.testing.assert_array_equal(run(MERGE, {"A": a, "B": b}).pixels, [[[0.5, 0.5, 0, 1]]])


# ---------------------------------------------------------------------- types in a graph


def document(a, b):
    """Return a graph that merges two outputs of a line drawing or a plate, and needs the result as a matte."""
    return {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1"},
            "dog": {"type": "dog@1", "inputs": {"image": "plate"}},
            "both": {"type": "merge@1", "inputs": {"A": a, "B": b}, "params": {"operation": "min"}},
            "comp": {"type": "composite@1", "inputs": {"image": "plate", "lines": "both"}},
        },
    }


def test_two_line_drawings_are_joined():
    loaded = load_graph(document("dog", "dog"))
    plate = Image.from_array(np.abs(noise(12, 10, 3)))
    result = loaded.run(given={"plate": plate}, outputs=["both", "dog", "comp"])
    assert result["both"].type == "matte"
    np.testing.assert_array_equal(result["both"].pixels, result["dog"].pixels)


@pytest.mark.parametrize(
    ("a", "b", "found"), [("dog.response", "dog", "mono"), ("dog", "plate", "color"), ("plate", "dog", "color")]
)
def test_the_wider_type_is_no_matte(a, b, found):
    (problem,) = graph.check(document(a, b))
    assert (problem.code, problem.pointer) == ("wrong-type", "/nodes/comp/inputs/lines")
    assert problem.found == f"both.image, which is {found}"


def test_what_is_no_picture_is_refused():
    with pytest.raises(GraphError, match=r"color or mono or matte"):
        load_graph(
            {
                "format": "flowabs.graph/1",
                "nodes": {
                    "plate": {"type": "read@1"},
                    "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
                    "both": {"type": "merge@1", "inputs": {"A": "flow", "B": "plate"}},
                },
            }
        )
