"""``write`` with a display and a view: a file holds what a viewer shows, and says of which display it is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.color.display import find_view, to_display
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import build_picture, save
from tests.color.configs import with_displays
from tests.io.files import colors
from tests.io.test_encode_flat import codes, spec


def written(path: Path, image: Image, **params: Any) -> list[str]:
    """Write an image, and return the warnings."""
    said: list[str] = []
    save(build_picture(image, **params), path, warn=said.append)
    return said


def chunks(path: Path) -> list[str]:
    """Return the names of a PNG's chunks before its pixels."""
    data, place, names = path.read_bytes(), 8, []
    while (name := data[place + 4 : place + 8]) != b"IDAT":
        names.append(name.decode())
        place += 12 + int.from_bytes(data[place : place + 4], "big")
    return names


def test_a_png_is_what_openimageio_shows(tmp_path):
    image = Image.from_array(colors() * 4, "lin_ap1_scene")
    assert written(tmp_path / "a.png", image, view="default") == []
    shown = oiio.ImageBufAlgo.ociodisplay(
        oiio.ImageBuf(image.pixels.astype(np.float32)),
        "sRGB - Display",
        "ACES 1.0 - SDR Video",
        "ACEScg",
        unpremult=False,
        colorconfig="ocio://studio-config-v2.2.0_aces-v1.3_ocio-v2.4",
    )
    expected = np.clip(shown.get_pixels(oiio.FLOAT), 0, 1) * 255
    np.testing.assert_allclose(codes(tmp_path / "a.png"), expected, atol=0.6)
    assert "sRGB" in chunks(tmp_path / "a.png")


def test_without_display_and_view_nothing_changes(tmp_path):
    image = Image.from_array(colors())
    written(tmp_path / "a.png", image)
    written(tmp_path / "b.png", image, display="", view="")
    written(tmp_path / "c.png", image, view="default")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert (codes(tmp_path / "a.png") != codes(tmp_path / "c.png")).any()


def test_alpha_is_straight_and_colours_go_through_the_view_without_it(tmp_path):
    rgb = colors().astype(np.float32)
    alpha = np.linspace(0.2, 1, rgb[..., :1].size, dtype=np.float32).reshape(rgb[..., :1].shape)
    written(tmp_path / "a.png", Image.from_array(np.concatenate([rgb * alpha, alpha], axis=2)), view="default")
    written(tmp_path / "b.png", Image.from_array(rgb), view="default")
    found = codes(tmp_path / "a.png")
    assert abs(found[..., :3].astype(int) - codes(tmp_path / "b.png")).max() <= 1
    np.testing.assert_allclose(found[..., 3], alpha[..., 0] * 255, atol=0.6)


@pytest.mark.parametrize(
    ("display", "cicp"),
    [("Display P3 - Display", (12, 13, 0, 1)), ("Rec.2100-PQ - Display", (9, 16, 0, 1))],
)
@pytest.mark.skipif(oiio.VERSION < 30100, reason="this OpenImageIO writes no cICP")
def test_a_png_says_other_displays_by_cicp(tmp_path, display, cicp):
    assert written(tmp_path / "a.png", Image.from_array(colors()), display=display) == []
    assert spec(tmp_path / "a.png").getattribute("CICP") == cicp
    assert "sRGB" not in chunks(tmp_path / "a.png")


def test_a_tiff_says_other_displays_by_a_profile(tmp_path):
    light = Image.from_array(colors().clip(0, 1) * 0.5, "lin_rec709")
    assert written(tmp_path / "a.tif", light, display="Display P3 - Display", view="Un-tone-mapped") == []
    assert spec(tmp_path / "a.tif").getattribute("ICCProfile") is not None
    back = read_image(tmp_path / "a.tif")
    assert back.colorspace.name == "lin_p3d65_scene"


@pytest.mark.parametrize(("name", "display"), [("a.png", "P3-D60 - Display"), ("a.tif", "Rec.2100-HLG - Display")])
def test_a_display_that_the_file_cannot_name_is_not_called_srgb(tmp_path, name, display):
    (said,) = written(tmp_path / name, Image.from_array(colors()), display=display)
    assert f"cannot say that its colours are of {display!r}" in said
    if name.endswith("png"):
        assert "sRGB" not in chunks(tmp_path / name)


def test_a_view_of_data_writes_the_numbers(tmp_path):
    image = Image.from_array(colors().clip(0, 1), "lin_ap1_scene")
    assert written(tmp_path / "a.png", image, view="Raw") == []
    np.testing.assert_allclose(codes(tmp_path / "a.png"), image.pixels * 255, atol=0.6)


def test_mattes_and_monos_stay_as_they_are(tmp_path):
    for kind in ("matte", "mono"):
        image = Image.from_array(np.linspace(0, 1, 60).reshape(6, 10), type=kind)
        assert written(tmp_path / f"{kind}.png", image, view="default") == []
        np.testing.assert_allclose(codes(tmp_path / f"{kind}.png")[..., 0], image.pixels[..., 0] * 255, atol=0.6)
    assert written(tmp_path / "a.exr", image, view="default") == []


def test_an_exr_with_a_view_holds_codes_and_says_so(tmp_path):
    image = Image.from_array(colors(channels=4).astype(np.float32), "lin_ap1_scene")
    (said,) = written(tmp_path / "a.exr", image, view="default", data_type="float")
    assert "codes of a display (sRGB - Display, ACES 1.0 - SDR Video)" in said
    header = spec(tmp_path / "a.exr")
    assert header.getattribute("colorInteropID") == "srgb_rec709_display"
    assert header.getattribute("chromaticities") is None
    pixels = oiio.ImageBuf(str(tmp_path / "a.exr")).get_pixels(oiio.FLOAT)
    alpha = image.pixels[..., 3:]
    straight = np.ascontiguousarray(image.pixels[..., :3] / alpha)
    expected = to_display(straight, image.colorspace, find_view()) * alpha
    np.testing.assert_allclose(pixels[..., :3], expected, atol=1e-5)


def test_the_runs_own_config(tmp_path):
    settings = Settings(ocio=with_displays(tmp_path / "studio.ocio"))
    image = Image.from_array(np.full((2, 2, 3), 0.25, np.float32), "lin_ap1_scene")
    assert written(tmp_path / "a.png", image, view="film", settings=settings) == []
    np.testing.assert_array_equal(codes(tmp_path / "a.png"), 128)
    with pytest.raises(ColorError, match="no view 'Raw' for the display 'wall'"):
        written(tmp_path / "b.png", image, view="Raw", settings=settings)
    assert not (tmp_path / "b.png").exists()


def test_a_colour_space_beside_a_view_is_refused():
    with pytest.raises(ArgumentError, match="colorspace: 'sRGB' and a display or view cannot both"):
        build_picture(Image.from_array(colors()), colorspace="sRGB", view="default")


def test_a_plates_own_profile_is_not_kept_beside_a_view(tmp_path):
    photo = Image.from_array(colors().clip(0, 1), "lin_p3d65_scene")
    written(tmp_path / "p3.tif", photo, display="Display P3 - Display", view="Un-tone-mapped")
    written(tmp_path / "a.tif", read_image(tmp_path / "p3.tif"), view="default")
    assert spec(tmp_path / "a.tif").getattribute("ICCProfile") is None
