"""Names of scene-linear spaces, and that OCIO means the same by them."""

import re

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import config, named
from flowabs_nodes.color.spaces import KNOWN, SOURCES, between, convert
from flowabs_nodes.errors import ColorError


@pytest.mark.parametrize("name", SOURCES)
def test_aliases(name):
    for alias in (name, *SOURCES[name][1]):
        for spelled in (alias, alias.lower(), alias.upper()):
            assert color.space(spelled) is KNOWN[name]


@pytest.mark.parametrize("name", SOURCES)
def test_ocio_agrees_about_every_alias(name):
    known_there = [alias for alias in (name, *SOURCES[name][1]) if config.has(alias)]
    assert name in known_there
    for alias in known_there:
        found = named._measured(config.canonical(alias), None)
        assert (found.kind, found.space) == ("linear", KNOWN[name]), alias


def test_other_spaces_of_the_config():
    assert color.space("scene_linear") is KNOWN["lin_ap1_scene"]  # the role
    camera = color.space("lin_arri_wide_gamut_3")
    assert camera.name == "Linear ARRI Wide Gamut 3"
    assert color.space(camera.name) == camera
    grey = np.full((1, 1, 3), 0.18, np.float32)
    assert color.encode(grey, colorspace=camera)[0, 0] / 2.55 == pytest.approx([49.496, 0, 0], abs=1e-3)
    # As OCIO itself takes it to AP0.
    red = np.float32([[[1, 0, 0]]])
    expected = config.convert(red, camera.name, "ACES2065-1")
    np.testing.assert_allclose(convert(red, camera, KNOWN["lin_ap0_scene"]), expected, atol=1e-5)


def test_a_space_is_a_value():
    space = color.space("lin_rec709")
    assert color.space(space) is space
    assert str(space) == space.name == "lin_rec709"
    assert repr(space) == "ColorSpace('lin_rec709')"
    assert len({space, color.ColorSpace("lin_rec709", space.to_xyz), color.space("ACEScg")}) == 2
    assert space.interop_id == "lin_rec709_scene"
    assert color.space("ACEScg").interop_id == "lin_ap1_scene"
    assert color.space("Linear V-Gamut").interop_id is None


@pytest.mark.parametrize(
    ("name", "message", "hint"),
    [
        ("lin_rec70", "no colour space 'lin_rec70'", "'lin_rec709'"),
        ("zzzzzz", "no colour space 'zzzzzz'", "lin_ap1_scene"),
        ("sRGB", "not scene-linear", "lin_rec709"),
        ("ACEScct", "not scene-linear", "lin_ap1_scene"),
        # OpenColorIO 2.4's config does not have it, but a role of a name like it.
        ("CIE XYZ-D65 - Scene-referred", "(not scene-linear|no colour space)", "lin_rec709|cie_xyz_d65_interchange"),
        ("raw", "holds data", "lin_rec709"),
        ("", "not the name", "lin_rec709"),
        (None, "not the name", "lin_rec709"),
    ],
)
def test_errors_hint_at_the_right_name(name, message, hint):
    with pytest.raises(ColorError, match=message) as caught:
        color.space(name)
    assert re.search(hint, caught.value.hint)


def test_between_spaces():
    rgb = np.random.default_rng(0).uniform(-0.2, 4, (5, 6, 3)).astype(np.float32)
    for source in KNOWN.values():
        for target in KNOWN.values():
            there = convert(rgb, source, target)
            np.testing.assert_allclose(there, rgb @ between(source, target).T, rtol=1e-5, atol=1e-5)
            np.testing.assert_allclose(convert(there, target, source), rgb, atol=1e-5)
            assert (convert(np.full((1, 1, 3), 0.3, np.float32), source, target) == np.float32(0.3)).all()


@pytest.mark.parametrize(("source", "target"), [("lin_rec709", "lin_ap1_scene"), ("lin_ap0_scene", "lin_p3d65_scene")])
def test_between_spaces_is_ocios(source, target):
    rgb = np.eye(3, dtype=np.float32)[None]
    np.testing.assert_allclose(
        convert(rgb, KNOWN[source], KNOWN[target]), config.convert(rgb, source, target), atol=3e-5
    )
