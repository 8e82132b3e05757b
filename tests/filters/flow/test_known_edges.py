"""Edges from passes in ``etf``: they count as gradients beside the picture's own."""

import numpy as np
import pytest

from flowabs_nodes.engine.keys import node_key
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf
from flowabs_nodes.filters.flow.etf import etf_and_reference
from flowabs_nodes.nodes.flow import ETF
from tests.filters.flows import THIN, random_flow
from tests.filters.pictures import noise, photo
from tests.naive import etf as naive

GREY = photo().mean(-1)


def ring(shape=(64, 64), radius=20.0):
    """Return the strength and the tangents of a circle that no picture shows."""
    y, x = np.indices(shape) - (np.array(shape)[:, None, None] - 1) / 2
    off = np.hypot(x, y)
    flow = np.stack([-y, x], -1) / np.maximum(off, 1e-6)[..., None]
    return np.clip(2 - np.abs(off - radius), 0, 1).astype(np.float32), flow.astype(np.float32)


@pytest.mark.parametrize(
    "code", [GREY, photo(), noise(140, 41), noise(40, 9)], ids=["photo", "colour", "noise", "thin"]
)
@pytest.mark.parametrize(("kernel", "fill"), [("full", None), ("full", 2.0), ("separable", 0.0)])
def test_equals_the_equations_in_float64(code, kernel, fill):
    edges = {"strength": ring(code.shape[:2], 12)[0], "flow": random_flow(code.shape, 3), "weight": 40.0}
    known = {f"edge_{name}": value for name, value in edges.items()}
    flow = etf(code, 5.0, 3, kernel, fill=fill, **known)
    error = naive.degrees_between(flow, naive.etf(code, 5.0, 3, kernel, fill=fill, edges=tuple(edges.values())))
    assert flow.dtype == np.float32
    assert np.median(error) < 2e-4
    assert np.quantile(error, 0.999) < 0.05


@pytest.mark.parametrize("options", [{}, {"fill": 4.0}, {"fill": None}, {"working_scale": "1/2"}])
@pytest.mark.parametrize("none", [{"edge_weight": 0.0}, {"edge_strength": np.zeros((64, 64))}])
def test_edges_without_strength_or_weight_change_no_bit(options, none):
    strength, flow = ring()
    edges = {"edge_strength": strength, "edge_flow": flow, **none}
    np.testing.assert_array_equal(etf(GREY, **options, **edges), etf(GREY, **options))


def test_a_flat_picture_follows_edges_that_it_does_not_show():
    strength, flow = ring()
    found = etf(np.full((64, 64), 90.0), edge_strength=strength, edge_flow=flow)
    assert naive.degrees_between(found, flow)[strength > 0.5].max() < 3
    assert naive.degrees_between(etf(np.full((64, 64), 90.0)), flow)[strength > 0.5].max() > 80


def test_the_stronger_one_of_two_edges_across_each_other_decides():
    stripes = np.tile(30 * np.arange(64.0) % 256, (64, 1)) * 0 + 20 * np.arange(64.0)  # 20 codes/px along x
    along_x = np.tile(np.float32([1, 0]), (64, 64, 1))
    ones = np.ones((64, 64), np.float32)
    for weight, tangent in ((15.0, [0, 1]), (25.0, [1, 0])):
        found = etf(stripes, edge_strength=ones, edge_flow=along_x, edge_weight=weight)
        assert naive.degrees_between(found, tangent)[:, 8:-8].max() < 0.1


def test_edges_along_each_other_add_up_and_count_for_full_strength():
    ramp = np.tile(3.0 * np.arange(40.0), (30, 1))
    along_y = np.tile(np.float32([0, 1]), (30, 40, 1))
    edges = {"edge_strength": np.ones((30, 40)), "edge_flow": along_y, "edge_weight": 4.0}
    arguments = (ramp, 5.0, 3, "full", 0.0, "max")
    assert etf_and_reference(*arguments, fill=0.0, adaptive=False, **edges)[1] == pytest.approx(5.0)
    assert etf_and_reference(*arguments, fill=0.0, adaptive=False)[1] == pytest.approx(3.0)


def test_two_edges_as_strong_across_each_other_leave_the_tangent():
    ramp = np.tile(4.0 * np.arange(40.0), (30, 1))
    edges = {"edge_strength": np.ones((30, 40)), "edge_flow": np.tile(np.float32([1, 0]), (30, 40, 1))}
    found = etf(ramp, iterations=0, fill=None, edge_weight=4.0, **edges)
    np.testing.assert_array_equal(found[:, 1:-1], np.tile(np.float32([0, 1]), (30, 38, 1)))


def test_the_sign_of_the_edges_does_not_count_and_strengths_beyond_1_are_1():
    strength, flow = ring()
    signs = np.random.default_rng(0).choice([-1, 1], (64, 64, 1)).astype(np.float32)
    one = etf(GREY, edge_strength=strength, edge_flow=flow)
    np.testing.assert_array_equal(etf(GREY, edge_strength=strength, edge_flow=flow * signs), one)
    more = np.where(strength == 1, 7, np.where(strength == 0, -1, strength))
    np.testing.assert_array_equal(etf(GREY, edge_strength=more, edge_flow=flow), one)


@pytest.mark.parametrize("scale", ["1/2", "1/4"])
def test_a_smaller_picture_follows_the_same_edges(scale):
    strength, flow = ring((128, 128), 40)
    code = np.full((128, 128), 20.0)
    small, full = (
        etf(code, 12.0, edge_strength=strength, edge_flow=flow, working_scale=each) for each in (scale, "full")
    )
    assert naive.degrees_between(small, full)[strength > 0.5].max() < 3


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    edges = {"edge_strength": np.ones(shape, np.float32), "edge_flow": random_flow(shape, 1)}
    found = etf(noise(*shape), fill=None, **edges)
    expected = naive.etf(noise(*shape), 5.0, 3, edges=(*edges.values(), 60.0))
    assert np.median(naive.degrees_between(found, expected)) < 1e-3


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    strength, flow = ring((150, 70))
    one, *others = each_thread_count(lambda: etf(noise(150, 70), edge_strength=strength, edge_flow=flow))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_the_key_of_a_flow_without_edges_is_what_it_was():
    before = {name: value for name, value in ETF.defaults().items() if name != "edge_weight"}
    assert node_key(ETF, ETF.defaults(), {"image": ["a", "image"]}) == node_key(ETF, before, {"image": ["a", "image"]})


def test_errors_name_the_argument():
    strength, flow = ring()
    for message, edges in {
        "edge_strength needs edge_flow too": {"edge_strength": strength},
        "edge_flow needs edge_strength too": {"edge_flow": flow},
        "edge_strength: expected the size of the picture, 64x64": {"edge_strength": strength[1:], "edge_flow": flow},
        r"edge_flow: expected shape \(H, W, 2\)": {"edge_strength": strength, "edge_flow": flow[..., :1]},
        "edge_weight: expected a number at least 0": {"edge_weight": -1},
    }.items():
        with pytest.raises(ArgumentError, match=message):
            etf(GREY, **edges)
