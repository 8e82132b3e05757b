"""Lines between colours of equal lightness, by the shipped graphs and in each space of code values."""

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.nodes import registry

REC709 = np.array([0.2126, 0.7152, 0.0722])
GREEN, RED, BLUE = (0.05, 0.2, 0.05), (0.5, 0.08, 0.1), (0.1, 0.1, 0.9)


def disc(inside, outside, size=270):
    """A disc before a ground of the same luminance, scene-linear."""
    y, x = np.mgrid[:size, :size]
    colors = [np.array(color) * 0.18 / (REC709 @ color) for color in (inside, outside)]
    return np.where((np.hypot(x - size / 2, y - size / 2) < size / 4)[..., None], *colors).astype(np.float32)


def ink(graph, rgb, node="lines", **params):
    image = fa.Image.from_array(rgb, colorspace="lin_rec709")
    lines = fa.load_graph(graph).run(given={"plate": image}, set=params, outputs=[node])[node]
    return 1 - lines.pixels[..., 0]


@pytest.mark.parametrize(
    ("graph", "node"), [("lines", "lines"), ("abstraction", "lines"), ("inked", "fine"), ("inked", "bold")]
)
@pytest.mark.parametrize("colors", [(RED, GREEN), (BLUE, GREEN), (RED, BLUE)], ids=["red", "blue", "both"])
def test_shipped_graphs_outline_a_shape_of_equal_lightness(graph, node, colors):
    drawn = ink(graph, disc(*colors), node)
    y, x = np.nonzero(drawn > 0.5)
    assert np.unique(np.degrees(np.arctan2(y - 135, x - 135)) % 360 // 20).size == 18  # all the way round
    assert abs(np.hypot(x - 135, y - 135) - 67.5).max() < 5


@pytest.mark.parametrize("graph", ["lines", "abstraction"])
def test_without_color_sign_nothing_is_drawn_there(graph):
    assert ink(graph, disc(RED, GREEN), **{"lines.color_sign": False}).max() < 0.1


@pytest.mark.parametrize("node", ["fdog", "fdog_iterative"])
def test_the_paper_s_form_is_the_default_of_the_nodes(node):
    params = {param.name: param for param in registry.catalogue()[node].params}
    assert params["color_sign"].default is False


@pytest.mark.parametrize("colors", [(RED, GREEN), (BLUE, GREEN)], ids=["red", "blue"])
def test_in_acescct_too(colors):
    rgb = disc(*colors)
    params = {"lines.space": "acescct", "flow.space": "acescct", "pre.space": "acescct", "lines.color_weight": 1.0}
    assert (ink("lines", rgb, **params) > 0.2).sum() > 300


def test_evidence_is_off_by_default_and_counts_in_the_paper_s_form_alone():
    rgb = 0.2 + 0.12 * np.random.default_rng(1).random((48, 64, 3), np.float32)
    for name in ("fdog", "fdog_iterative"):
        nodes = {
            "plate": {"type": "read@1"},
            "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
            "lines": {"type": f"{name}@1", "inputs": {"image": "plate", "flow": "flow"}},
            "out": {"type": "write@1", "inputs": {"image": "lines"}},
        }
        graph = {"format": "flowabs.graph/1", "name": "evidence", "nodes": nodes}
        soft = {"lines.rho": 1.0, "lines.contrast": 0.5, "lines.softness": 4.0}
        plain, off, full = (ink(graph, rgb, **soft, **more) for more in ({}, evidence(0), evidence(1)))
        np.testing.assert_array_equal(plain, off)
        assert full.sum() < 0.8 * plain.sum()
        xdog, and_evidence = (ink(graph, rgb, **{"lines.form": "xdog"}, **more) for more in ({}, evidence(1)))
        np.testing.assert_array_equal(xdog, and_evidence)


def evidence(value):
    return {"lines.evidence": float(value)}
