"""Names under a studio's config: the config's own first, ours where it lacks them, through the interchange role."""

import threading

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import config, named
from flowabs_nodes.color.spaces import SOURCES
from flowabs_nodes.errors import ColorError
from tests.studio import STUDIO, studio

RGB = np.random.default_rng(0).uniform(0.05, 1, (3, 4, 3)).astype(np.float32)


@pytest.fixture
def show(tmp_path):
    return studio(tmp_path)


@pytest.mark.parametrize("name", [each for name, (_, aliases) in SOURCES.items() for each in (name, *aliases)])
def test_our_names_that_it_lacks_mean_what_they_mean_without_it(name, show):
    assert color.space(name, show) == color.space(name)


@pytest.mark.parametrize(
    "name", ["sRGB - Texture", "srgb_tx", "cineon", "data", "ACEScct", "g22_rec709_scene", "rec1886_rec709_display"]
)
def test_encodings_that_it_lacks_come_from_the_pinned_config(name, show):
    ours, theirs = color.ocio.linearize(RGB, name), color.ocio.linearize(RGB, name, show)
    assert ours[1] == theirs[1]
    np.testing.assert_array_equal(ours[0], theirs[0])
    np.testing.assert_array_equal(
        color.ocio.encode_named(RGB, ours[1], name), color.ocio.encode_named(RGB, ours[1], name, show)
    )


def test_its_own_names_go_before_ours(show):
    assert named.find("sRGB", show).kind == "encoded"
    assert named.find("srgb_rec709_scene", show).kind == "srgb"
    half = np.full((1, 1, 3), 0.5, np.float32)
    assert color.ocio.linearize(half, "sRGB", show)[0][0, 0, 0] == pytest.approx(0.5**1.8, rel=1e-3)


def test_a_camera_of_the_pinned_config_is_not_lent(show):
    with pytest.raises(ColorError, match="has no colour space 'ARRI LogC4'") as caught:
        color.ocio.linearize(RGB, "ARRI LogC4", show)
    assert caught.value.hint == f"the built-in config has it: {config.PINNED}"


def test_between_its_spaces_and_ours(show):
    """show_lin is ACEScg by another name, so all of this is known without the config."""
    codes = color.ocio.encode_named(RGB, color.space("lin_rec709"), "show_log", show)
    ap1 = color.ocio.encode_named(RGB, color.space("lin_rec709"), "ACEScg")
    np.testing.assert_allclose(10.0**codes, ap1, rtol=1e-3)
    back, space = color.ocio.linearize(codes, "show_log", show)
    assert space.name == "lin_ap1_scene"
    np.testing.assert_allclose(color.ocio.encode_named(back, space, "lin_rec709", show), RGB, rtol=2e-3, atol=1e-4)
    np.testing.assert_array_equal(color.ocio.linearize(RGB, "plate_lin", show)[0], RGB)


def test_a_space_like_the_reference_is_no_data(show):
    assert named.find("house_reference", show).kind == "linear"
    assert color.space("house_reference", show).name == "lin_ap0_scene"
    assert named.find("bytes", show).kind == "data"


def test_without_an_interchange_role(tmp_path):
    alone = studio(tmp_path, interchange="")
    for name in ("show_lin", "show_log", "scene_linear"):
        with pytest.raises(ColorError, match=r"no interchange role \(aces_interchange\)") as caught:
            color.ocio.linearize(RGB, name, alone)
        assert alone in str(caught.value)
        assert caught.value.code == "no-interchange"
    assert color.space("lin_rec709", alone) == color.space("lin_rec709")
    assert color.ocio.linearize(RGB, "sRGB - Texture", alone)[1].name == "lin_rec709"
    with pytest.raises(ColorError, match="no interchange role"):
        color.ocio.encode_named(RGB, color.space("lin_rec709"), "show_log", alone)


def test_a_header_that_names_such_a_space_is_not_taken_for_another(tmp_path):
    spec = oiio.ImageSpec(1, 1, 3, "half")
    spec.attribute("colorInteropID", "show_log")
    with pytest.raises(ColorError, match="no interchange role"):
        color.detect(spec, ocio=studio(tmp_path, interchange=""))


@pytest.mark.parametrize("known", ["ACES2065-1", "ACES - ACES2065-1"])
def test_a_well_known_name_ties_a_config_without_roles(tmp_path, known):
    path = studio(tmp_path, interchange="", text=STUDIO.replace("house_reference", known))
    assert color.space("show_lin", path).name == "lin_ap1_scene"


DISPLAYS = """ocio_profile_version: 2
roles: {default: raw, cie_xyz_d65_interchange: xyz}
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  monitor:
    - !<View> {name: Raw, colorspace: raw}
colorspaces:
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace> {name: scene}
display_colorspaces:
  - !<ColorSpace> {name: xyz}
  - !<ColorSpace>
    name: monitor
    from_display_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [3.2409699, -1.5373832, -0.4986108, 0, -0.9692436, 1.8759675, 0.0415551, 0,
            0.0556301, -0.2039770, 1.0569715, 0, 0, 0, 0, 1]}
        - !<ExponentTransform> {value: 2.4, direction: inverse}
"""


def test_a_display_by_cie_xyz(tmp_path):
    path = tmp_path / "config.ocio"
    path.write_text(DISPLAYS)
    linear, space = color.ocio.linearize(RGB, "monitor", str(path))
    assert space.name == "lin_rec709"
    np.testing.assert_allclose(linear, RGB**2.4, rtol=2e-3, atol=1e-4)
    np.testing.assert_allclose(color.ocio.encode_named(linear, space, "monitor", str(path)), RGB, atol=1e-3)
    with pytest.raises(ColorError, match="no interchange role"):
        color.space("scene", str(path))


def test_a_typo_gets_the_nearest_name(show):
    for typo, right in (("show_ling", "show_lin"), ("scene_linaer", "scene_linear"), ("lin_rec790", "lin_rec709")):
        with pytest.raises(ColorError) as caught:
            color.space(typo, show)
        assert repr(right) in caught.value.hint


def test_a_config_is_parsed_once_for_a_content(tmp_path, monkeypatch):
    path, calls, parse = studio(tmp_path), [], oiio.ColorConfig
    monkeypatch.setattr(oiio, "ColorConfig", lambda name: calls.append(name) or parse(name))
    threads = [threading.Thread(target=config.config, args=(path,)) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    color.space("show_lin", path)
    assert calls == [path]
