"""Spaces from the primaries of an EXR header."""

import warnings

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color.constants import CHROMATICITIES
from flowabs_nodes.color.spaces import KNOWN, SOURCES
from flowabs_nodes.errors import ColorError

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import colour

PROPHOTO = (0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.345704, 0.35854)
XYZ = (1, 0, 0, 1, 0, 0, 1 / 3, 1 / 3)


def make(values):
    return color.space_from_chromaticities(values[0:2], values[2:4], values[4:6], values[6:8])


@pytest.mark.parametrize("name", SOURCES)
def test_known_primaries_are_the_known_space(name):
    values = np.array(CHROMATICITIES[SOURCES[name][0]])
    assert make(values) is KNOWN[name]
    assert make(values.astype(np.float32)) is KNOWN[name]
    assert make(values + 9e-4) is KNOWN[name]
    assert make(values + 2e-3).name.startswith("chromaticities(")
    assert color.chromaticities_of(KNOWN[name]) == tuple(values)


def test_the_matrix_is_colour_sciences():
    space = make(PROPHOTO)
    expected = colour.normalised_primary_matrix(np.reshape(PROPHOTO[:6], (3, 2)), PROPHOTO[6:])
    np.testing.assert_allclose(np.reshape(space.to_xyz, (3, 3)), expected, atol=1e-12)
    assert space.name == "chromaticities(0.7347,0.2653,0.1596,0.8404,0.0366,0.0001,0.345704,0.35854)"


def test_imaginary_primaries():
    space = make(XYZ)  # CIE XYZ itself as RGB: y of X and of Z is 0
    np.testing.assert_allclose(np.reshape(space.to_xyz, (3, 3)), np.eye(3), atol=1e-5)
    assert color.luminance([0.2, 0.5, 0.1], space) == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("values", [PROPHOTO, XYZ, np.float32(PROPHOTO)])
def test_found_again_by_name(values):
    space = make(values)
    assert color.space(space.name) == space
    assert color.space(str(space)).to_xyz == space.to_xyz
    assert color.chromaticities_of(space) == pytest.approx(tuple(values), abs=1e-6)
    rgb = np.random.default_rng(0).random((3, 4, 3)).astype(np.float32)
    for code in color.SPACES:
        np.testing.assert_allclose(color.decode(color.encode(rgb, code, space), code, space), rgb, atol=2e-5)


@pytest.mark.parametrize(
    "values",
    [
        (0,) * 8,
        (np.nan,) * 8,
        (np.inf, *PROPHOTO[1:]),
        (1e30, *PROPHOTO[1:]),
        (0.1, 0.1, 0.2, 0.2, 0.3, 0.3, 0.3127, 0.329),  # on one line
        (0.64, 0.33, 0.64, 0.33, 0.15, 0.06, 0.3127, 0.329),  # twice the same
        (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0),  # no luminance
        (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, -0.1, 0.5),
        (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.64, 0.33),  # white is the red primary
        PROPHOTO[:7],
    ],
)
def test_what_spans_no_colours_is_an_error(values):
    with pytest.raises(ColorError, match="chromaticities") as caught:
        make(values)
    assert caught.value.code == "bad-chromaticities"


@pytest.mark.parametrize(
    "name", ["chromaticities()", "chromaticities(1,2)", "chromaticities(a,b,c,d,e,f,g,h)", "chromaticities(1"]
)
def test_names_that_are_none(name):
    with pytest.raises(ColorError, match="expected chromaticities"):
        color.space(name)


def test_a_config_only_space_has_no_chromaticities_to_write():
    assert color.chromaticities_of(color.space("Linear V-Gamut")) is None
