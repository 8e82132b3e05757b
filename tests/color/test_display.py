"""Displays and views: found by name, applied as OpenColorIO does, and told to files by what their codes are."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import config, srgb
from flowabs_nodes.color.display import DEFAULT, DisplayView, displays, find_view, to_display, views
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.spaces import KNOWN
from flowabs_nodes.errors import ColorError
from tests.color.configs import with_displays, without_displays

COLORS = np.array([[[0.18, 0.18, 0.18], [1, 1, 1], [8, 2, 0.1]], [[0, 0, 0], [0.5, 0.1, 0.9], [-0.01, 0.2, 0]]], "f4")


def test_the_default_is_the_configs_first():
    assert find_view() == find_view("", DEFAULT) == find_view(DEFAULT, "")
    assert find_view().display == displays()[0] == "sRGB - Display"
    assert find_view().view == views("sRGB - Display")[0]


def test_a_view_alone_is_one_of_the_default_display():
    assert find_view(view="Un-tone-mapped") == find_view("sRGB - Display", "Un-tone-mapped")


def test_names_are_found_in_any_case():
    assert find_view("display p3 - display", "RAW") == DisplayView("Display P3 - Display", "Raw", data=True)


@pytest.mark.parametrize(
    ("display", "view", "code", "said", "hint"),
    [
        ("sRBG - Display", "", "unknown-display", "it has 'sRGB - Display', 'Display P3", "'sRGB - Display'?"),
        ("", "ACES 1.0 SDR Video", "unknown-view", "it has 'ACES 1.0 - SDR Video', ", "'ACES 1.0 - SDR Video'?"),
        ("", "film noir", "unknown-view", "for the display 'sRGB - Display'", ""),
    ],
)
def test_a_name_that_there_is_not(display, view, code, said, hint):
    with pytest.raises(ColorError) as failure:
        find_view(display, view)
    assert failure.value.code == code
    assert said in failure.value.message
    assert hint in failure.value.hint


def test_the_colours_are_those_of_openimageio():
    chosen = find_view("Display P3 - Display")
    buf = oiio.ImageBuf(COLORS)
    expected = oiio.ImageBufAlgo.ociodisplay(
        buf, chosen.display, chosen.view, "lin_rec709_scene", unpremult=False, colorconfig=config.PINNED
    )
    shown = to_display(COLORS, KNOWN["lin_rec709"], chosen)
    np.testing.assert_allclose(shown, expected.get_pixels(oiio.FLOAT), atol=2e-4)


def test_without_tone_mapping_a_screen_of_srgb_shows_srgb():
    shown = to_display(COLORS.clip(0, 1), KNOWN["lin_rec709"], find_view(view="Un-tone-mapped"))
    np.testing.assert_allclose(shown, srgb.encoded(COLORS.clip(0, 1)), atol=1e-3)


def test_primaries_are_those_of_the_image():
    chosen = find_view()
    one, other = (to_display(COLORS, KNOWN[name], chosen) for name in ("lin_rec709", "lin_ap1_scene"))
    assert abs(one - other)[0, 2].max() > 0.05
    np.testing.assert_allclose(one[0, :2], other[0, :2], atol=1e-3)  # neutrals


def test_no_pixel_comes_out_as_nan():
    wild = np.array([[[np.nan, 0, 0], [np.inf, 1, 1], [-np.inf, 0, 0], [3e38, 3e38, 3e38]]], "f4")
    for name in displays():
        assert np.isfinite(to_display(wild, KNOWN["lin_rec709"], find_view(name))).all()


def test_a_view_of_data_changes_nothing():
    chosen = find_view(view="Raw")
    assert chosen.data
    assert chosen.encoding is None
    assert to_display(COLORS, KNOWN["lin_ap1_scene"], chosen) is COLORS


@pytest.mark.parametrize(
    ("display", "cicp"),
    [
        ("Display P3 - Display", (12, 13, 0, 1)),
        ("Rec.1886 Rec.709 - Display", (1, 1, 0, 1)),
        ("Rec.2100-PQ - Display", (9, 16, 0, 1)),
        ("Rec.2100-HLG - Display", (9, 18, 0, 1)),
        ("P3-D65 - Display", (12, 17, 0, 1)),
    ],
)
def test_the_codes_of_a_display_are_known(display, cicp):
    encoding = find_view(display).encoding
    assert isinstance(encoding, Encoding)
    assert encoding.cicp == cicp
    assert encoding.name == display


@pytest.mark.parametrize("display", ["Display P3 - Display", "Rec.1886 Rec.709 - Display", "P3-D65 - Display"])
def test_the_encoding_of_a_display_decodes_what_the_view_encoded(display):
    chosen = find_view(display, "Un-tone-mapped")
    light = np.array([[[0.2, 0.2, 0.2], [0.5, 0.3, 0.4], [1, 1, 1]]], "f4")
    decoded = chosen.encoding.linear(to_display(light, chosen.encoding.space, chosen))
    np.testing.assert_allclose(decoded, light, atol=3e-3)


def test_srgb_and_displays_that_no_file_can_name():
    assert find_view().encoding == "srgb_rec709_scene"
    assert find_view("P3-D60 - Display").encoding is None


def test_a_config_of_ones_own(tmp_path):
    ocio = with_displays(tmp_path / "studio.ocio")
    assert displays(ocio) == ["wall", "desk"]
    chosen = find_view(ocio=ocio)
    assert chosen == DisplayView("wall", "film", interop_id="srgb_rec709_display")
    quarter = np.full((1, 1, 3), 0.25, np.float32)
    np.testing.assert_allclose(to_display(quarter, KNOWN["lin_ap1_scene"], chosen, ocio), 0.5, atol=1e-4)
    with pytest.raises(ColorError, match="no view 'films' for the display 'desk': it has 'film'"):
        find_view("desk", "films", ocio)


@pytest.mark.skipif(not hasattr(oiio.ColorConfig, "isData"), reason="this OpenImageIO cannot tell")
def test_a_view_is_data_where_its_space_is(tmp_path):
    assert find_view("wall", "as numbers", with_displays(tmp_path / "studio.ocio")).data


def test_a_config_without_displays(tmp_path):
    ocio = without_displays(tmp_path / "studio.ocio")
    assert displays(ocio) == []
    with pytest.raises(ColorError, match="it has no displays"):
        find_view(ocio=ocio)
