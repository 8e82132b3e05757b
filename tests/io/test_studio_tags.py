"""Tags of files that a studio's config was used for say what the pixels are, to readers without it too."""

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import spaces
from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import save
from tests.studio import AP1_TO_AP0, STUDIO, studio

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
RGB = np.random.default_rng(3).uniform(0.1, 0.9, (6, 8, 3)).astype(np.float32)
ODD = "0.6, 0.3, 0.1, 0, 0.1, 0.8, 0.1, 0, 0.02, 0.08, 0.9, 0, 0, 0, 0, 1"


def saved(path, image, config, **how):
    """Save an image with a config, and return the file's header and what was warned of."""
    warnings = []
    settings = Settings(ocio=config)
    save(build_picture(image, settings=settings, data_type="float", **how), path, warn=warnings.append)
    header = OpenEXR.File(str(path), header_only=True).header() if path.suffix == ".exr" else {}
    return header, warnings


def plate(path, **header):
    """Write a float EXR with these attributes."""
    planes = {name: np.ascontiguousarray(RGB[..., i]) for i, name in enumerate("RGB")}
    OpenEXR.File({"type": OpenEXR.scanlineimage, **header}, planes).write(str(path))
    return path


def in_ap0(image):
    return spaces.convert(image.pixels[..., :3], image.colorspace, color.space("lin_ap0_scene"))


@pytest.mark.parametrize("tags", [{"chromaticities": AP0}, {"colorInteropID": "lin_rec709_scene"}, {}])
def test_what_the_user_says_goes_before_the_header(tmp_path, tags):
    show = studio(tmp_path / "show")
    image = read_image(plate(tmp_path / "in.exr", **tags), colorspace="show_log", settings=Settings(ocio=show))
    np.testing.assert_allclose(image.pixels, 10.0**RGB, rtol=1e-3)
    header, _ = saved(tmp_path / "out.exr", image, show)
    assert header["colorInteropID"] == "lin_ap1_scene"
    np.testing.assert_allclose(header["chromaticities"], color.chromaticities_of(color.space("ACEScg")), atol=1e-4)
    np.testing.assert_array_equal(read_image(tmp_path / "out.exr").pixels, image.pixels)


def test_a_log_of_the_studio_is_read_again_with_its_config(tmp_path):
    show = studio(tmp_path / "show")
    image = Image.from_array(RGB, colorspace="ACEScg")
    header, warnings = saved(tmp_path / "out.exr", image, show, colorspace="show_log")
    assert header["colorInteropID"] == "show_log"
    assert "chromaticities" not in header
    assert warnings == []
    back = read_image(tmp_path / "out.exr", settings=Settings(ocio=show))
    np.testing.assert_allclose(back.pixels, RGB, rtol=2e-3)


def test_a_name_that_others_know_by_another_meaning(tmp_path):
    show = studio(tmp_path / "show")
    image = Image.from_array(RGB)
    header, warnings = saved(tmp_path / "out.exr", image, show, colorspace="sRGB")
    assert header["colorInteropID"] == "unknown"
    assert any("'sRGB' is another space to readers without this OCIO config" in each for each in warnings)
    for suffix in (".png", ".tif"):
        saved(tmp_path / f"out{suffix}", image, show, colorspace="sRGB")
        back = read_image(tmp_path / f"out{suffix}")  # without the config: 1.8 by its ICC profile
        np.testing.assert_allclose(in_ap0(back), in_ap0(image), atol=5e-3)
    header, warnings = saved(tmp_path / "own.exr", image, None, colorspace="sRGB")
    assert (header["colorInteropID"], warnings) == ("sRGB", [])


@pytest.mark.parametrize("name", ["show_wide", "Linear ARRI Wide Gamut 4"])
def test_a_linear_space_of_the_studio_s_own_primaries(tmp_path, name):
    text = STUDIO.replace("name: show_lin\n", f"name: {name}\n").replace(
        "scene_linear: show_lin", f"scene_linear: {name}"
    )
    text = text.replace("[MATRIX]}", f"[{ODD}]}}", 1)
    assert text.count(ODD) == 1
    assert AP1_TO_AP0 not in text
    show = studio(tmp_path / "show", text=text)
    image = read_image(plate(tmp_path / "in.exr"), colorspace=name, settings=Settings(ocio=show))
    assert image.colorspace.name == name
    header, _ = saved(tmp_path / "out.exr", image, show)
    assert header.get("colorInteropID") == (name if name == "show_wide" else None)
    np.testing.assert_allclose(in_ap0(read_image(tmp_path / "out.exr")), in_ap0(image), atol=2e-3)
    with_config = read_image(tmp_path / "out.exr", settings=Settings(ocio=show))
    np.testing.assert_allclose(in_ap0(with_config), in_ap0(image), atol=2e-3)


def test_a_tag_that_cannot_be_converted_does_not_matter_where_the_user_says_more(tmp_path):
    alone = studio(tmp_path / "show", interchange="")
    path = plate(tmp_path / "in.exr", colorInteropID="show_log")
    image = read_image(path, colorspace="lin_rec709", settings=Settings(ocio=alone))
    np.testing.assert_array_equal(image.pixels, RGB)
