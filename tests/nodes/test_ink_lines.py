"""The nodes aov_lines and ink_lines one after the other, on a scene that is drawn here."""

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.aov_lines import AOV_LINES
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.ink_lines import INK_LINES

SIZE = 120
INKS = {"outline": (1.0, 0.0, 0.0), "object": (0.0, 1.0, 0.0), "intersection": (0.0, 0.0, 1.0)}


@pytest.fixture(scope="module")
def passes():
    """Return what aov_lines makes of a disc, nearer, before a wall that ends at the sky; a box touches the wall."""
    y, x = np.indices((SIZE, SIZE))
    disc, sky = np.hypot(x - 40.3, y - 60.1) < 24, y < 20
    box = (x > 85) & (y > 60) & (x < 110) & (y < 100)
    depth = np.where(disc, 5.0, np.where(sky, 1e10, 10.0)).astype(np.float32)
    ids = np.where(disc, 1, np.where(sky, 0, np.where(box, 3, 2))).astype(np.uint32)
    inputs = {"depth": Image.from_array(depth, type="depth"), "id": Image.from_array(ids, type="id")}
    return inputs | call_node(AOV_LINES, Context(), inputs, {})


def ink(passes, *more, **params):
    kinds = ("outline", "object", "material", "crease", "intersection", "distance", *more)
    return call_node(INK_LINES, Context(), {name: passes[name] for name in kinds}, params)


def test_each_kind_of_edge_has_its_width_and_colour(passes):
    widths = {"outline": 4.0, "object": 3.0, "intersection": 2.0}
    params = {f"{kind}_width": width for kind, width in widths.items()}
    found = ink(passes, **params, **{f"{kind}_color": color for kind, color in INKS.items()})
    image, lines = found["image"], found["lines"]
    assert (image.type, image.channels, lines.type) == ("color", ("R", "G", "B", "A"), "matte")
    np.testing.assert_array_equal(lines.pixels[..., 0], 1 - image.pixels[..., 3])
    np.testing.assert_allclose(image.pixels[..., :3].sum(-1), image.pixels[..., 3], atol=1e-6)
    horizon, around_disc, below_box = (
        image.pixels[10:30, 70:110],
        image.pixels[30:90, 10:71],
        image.pixels[90:110, 90:105],
    )
    assert horizon[..., 0].sum() / 40 == pytest.approx(4.0, rel=0.05)
    assert around_disc[..., 1].sum() / (2 * np.pi * (24 - 1.5)) == pytest.approx(3.0, rel=0.05)
    assert below_box[..., 2].sum() / 15 == pytest.approx(2.0, rel=0.05)
    assert max(horizon[..., 1:3].max(), around_disc[..., 0].max(), below_box[..., 0].max()) < 0.02


def test_ink_goes_over_a_picture(passes):
    plate = Image.from_array(np.full((SIZE, SIZE, 3), 0.5, np.float32))
    document = {
        "format": "flowabs.graph/1",
        "nodes": {
            "plate": {"type": "read@1"},
            "id": {"type": "read_id@1"},
            "passes": {"type": "aov_lines@1", "inputs": {"id": "id"}},
            "ink": {
                "type": "ink_lines@1",
                "inputs": {"object": "passes.object", "outline": "passes.outline", "distance": "passes.distance"},
                "params": {"outline_color": [0.8, 0.0, 0.0]},
            },
            "comp": {"type": "merge@1", "inputs": {"B": "plate", "A": "ink"}},
        },
    }
    graph = fa.load_graph(document)
    comp = graph.run(1, given={"plate": plate, "id": passes["id"]}, outputs=["comp"])["comp"]
    np.testing.assert_allclose(comp.pixels[60, 55, :3], [0.5, 0.5, 0.5])
    np.testing.assert_allclose(comp.pixels[21, 90, :3], [0.8, 0, 0], atol=0.05)


def test_farther_lines_are_thinner(passes):
    near_and_far = [
        1
        - ink(passes, "depth", object_width=3.0, outline_width=3.0, width_by_depth=power, reference_depth=5.0)[
            "lines"
        ].pixels[..., 0]
        for power in (0.0, 1.0)
    ]
    disc, horizon = np.s_[30:90, 10:71], np.s_[10:30, 70:110]
    np.testing.assert_allclose(near_and_far[1][disc], near_and_far[0][disc], atol=1e-5)
    assert near_and_far[1][horizon].sum() / near_and_far[0][horizon].sum() == pytest.approx(0.5, rel=0.05)


def test_taper_asks_for_a_flow_and_thins_ends(passes):
    cut = passes["outline"].pixels * (np.indices((SIZE, SIZE))[1] < 100)[..., None]  # a horizon that ends
    cut = passes | {"outline": passes["outline"].with_pixels(cut)}
    blunt, tapered = (1 - each["lines"].pixels[10:30] for each in (ink(cut), ink(cut, "flow", taper=12.0)))
    np.testing.assert_allclose(tapered[:, 70:85], blunt[:, 70:85], atol=1e-6)
    assert 0.02 < tapered[:, 95:100].sum() / blunt[:, 95:100].sum() < 0.6


def test_errors_say_what_is_missing(passes):
    with pytest.raises(FlowabsError, match="connect at least one of outline, object, material, crease, intersection"):
        call_node(INK_LINES, Context(), {"distance": passes["distance"]}, {})
    with pytest.raises(FlowabsError, match="width_by_depth: needs the depth"):
        ink(passes, width_by_depth=1.0)
    with pytest.raises(FlowabsError, match="taper: needs the flow"):
        ink(passes, taper=1.0)
