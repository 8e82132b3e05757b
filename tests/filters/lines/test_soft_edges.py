"""Soft outlines get the line of sharp ones: against float64, and on drawn edges, lines, rings and noise."""

import numpy as np
import pytest
from scipy import ndimage
from scipy.special import ndtr

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, fdog, fdog_iterative
from flowabs_nodes.filters.lines.soft_edges import SoftEdges
from tests.filters.flows import THIN, cases, large, random_flow
from tests.naive import fdog as naive
from tests.naive import soft_edges as naive_soft

#: Lines as graphs of photographs draw them.
DRAWN = {"rho": 1.0, "contrast": 0.65, "softness": 4.0, "iterations": 2, "pre_blur": 1.5}


def missing(code, flow, reach=7.0, **given):
    """What soft edges lack, and the same in float64, (H, W, C) both."""
    given = {"sigma_c": 1.0, "rho": 0.99, "color_weight": 0.0, "pre_blur": 0.0} | given
    planes = np.ascontiguousarray(np.moveaxis(np.atleast_3d(code), -1, 0))
    found = SoftEdges.checked(1.0, reach, **given).missing(planes, flow)
    expected = naive_soft.missing(np.atleast_3d(code), flow, reach, **given)
    return np.moveaxis(found, 0, -1), expected


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"reach": 3.0, "rho": 1.0, "pre_blur": 1.5},
        {"reach": 13.0, "sigma_c": 2.2, "pre_blur": 1.0},
        {"color_weight": 0.5, "pre_blur": 1.5},
    ],
)
def test_equals_the_edge_model_in_float64(given):
    image, flow = cases()["photo"]
    code = image if given.get("color_weight") else image[..., :1]
    found, expected = missing(code, flow, **given)
    assert np.abs(expected).max() > 1
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)


def test_pictures_of_several_tiles():
    y, x = np.mgrid[:150, :291]
    angle = 0.2 + 0.1 * np.sin(y / 30)
    flow = np.stack([-np.sin(angle), np.cos(angle)], -1).astype(np.float32)
    code = sum(60 * ndtr((x + 0.2 * y - place) / blur) for place, blur in ((70, 2), (150, 4), (240, 6))).astype(np.float32)
    found, expected = missing(code, flow)
    assert np.abs(expected).max() > 2
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    code = np.random.default_rng(2).uniform(0, 255, shape).astype(np.float32)
    found, expected = missing(code, random_flow(shape))
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)
