"""The node that draws lines from passes: what it needs, where its camera looks, what it makes."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.runnable import load_graph
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.aov_lines import AOV_LINES
from flowabs_nodes.nodes.declare import Context
from tests.filters.passes.scenes import disc_before_wall, roof


def passes():
    depth, ids = disc_before_wall()
    normals, _ = roof(60)
    return {
        "depth": Image.from_array(depth[..., None], type="depth"),
        "normal": Image.from_array(normals, type="normal"),
        "id": Image.from_array(ids[..., None], type="id"),
    }


def test_it_makes_what_the_filter_makes():
    given = passes()
    made = call_node(AOV_LINES, Context(), given, {"width": 2.0})
    expected = filters.aov_lines(
        given["depth"].pixels[..., 0], given["normal"].pixels, given["id"].pixels[..., 0], width=2.0
    )
    assert tuple(made) == expected._fields
    for name, image in made.items():
        np.testing.assert_array_equal(np.squeeze(image.pixels), getattr(expected, name))
    only = call_node(AOV_LINES, Context(wanted=frozenset({"outline"})), given, {})
    assert set(only) == {"outline"}


def test_one_of_three_passes_is_enough_and_none_is_an_error():
    given = passes()
    for name, image in given.items():
        assert call_node(AOV_LINES, Context(), {name: image}, {})["lines"].pixels.min() < 0.1
    with pytest.raises(FlowabsError, match="connect at least one of depth, normal, id") as caught:
        call_node(AOV_LINES, Context(), {"material": given["id"]}, {})
    assert caught.value.code == "missing-input"


def test_a_check_says_that_a_pass_is_missing_before_anything_runs():
    graph = {
        "format": "flowabs.graph/1",
        "nodes": {
            "ids": {"type": "read_id@1", "params": {"file": "a.exr"}},
            "lines": {"type": "aov_lines@1", "inputs": {"material": "ids"}},
            "out": {"type": "write@1", "inputs": {"image": "lines"}, "params": {"file": "b.exr"}},
        },
    }
    with pytest.raises(FlowabsError, match="at least one of depth, normal, id"):
        load_graph(graph)
    graph["nodes"]["lines"]["inputs"] = {"id": "ids"}
    assert load_graph(graph)


def test_passes_of_pictures_of_different_sizes_are_refused():
    given = passes()
    small = Image.from_array(given["normal"].pixels[:20], type="normal")
    with pytest.raises(FlowabsError) as caught:
        call_node(AOV_LINES, Context(), given | {"normal": small}, {})
    assert caught.value.code == "window-mismatch"


def test_the_camera_looks_at_the_middle_of_the_display_window():
    slope = 2 * np.tan(np.radians(60) / 2) / 80
    y, x = np.mgrid[:50, :80]
    ray = np.sqrt(1 + (slope * (x - 39.5)) ** 2 + (slope * (y - 24.5) / 2) ** 2)
    near = (y - 25) ** 2 + (x - 40) ** 2 < 100
    planar = 1 / (0.2 - 0.002 * x) * np.where(near, 0.8, 1)
    whole = Image.from_array((planar * ray).astype(np.float32)[..., None], type="depth")
    spec = whole.spec
    spec.attribute("PixelAspectRatio", 2.0)
    whole = Image(whole.pixels, spec, "depth")
    params = {"projection": "distance", "field_of_view": 60.0}
    full = call_node(AOV_LINES, Context(), {"depth": whole}, params)["lines"]
    np.testing.assert_allclose(full.pixels[..., 0], filters.aov_lines(planar).lines, atol=1e-3)
    window = whole.data_window._replace(x=20, y=5, width=50, height=40)
    part = call_node(AOV_LINES, Context(), {"depth": whole.on_window(window)}, params)["lines"]
    inner = (slice(10, 30), slice(10, 40))
    np.testing.assert_allclose(part.pixels[inner], full.on_window(window).pixels[inner], atol=1e-3)
