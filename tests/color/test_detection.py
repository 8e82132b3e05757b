"""Where a file's colour space comes from, in the documented order; no header makes it fail."""

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import detection
from flowabs_nodes.errors import ColorError

AP0 = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)


def header(chromaticities=None, **tags):
    spec = oiio.ImageSpec(2, 2, 3, "half")
    for name, value in tags.items():
        spec.attribute({"tag": "oiio:ColorSpace"}.get(name, name), value)
    if chromaticities is not None:
        spec.attribute("chromaticities", f"float[{len(chromaticities)}]", chromaticities)
    return spec


def found(spec, *args, **kwargs):
    result = color.detect(spec, *args, **kwargs)
    return result.space.name, result.how, result.encoding


def test_the_order():
    everything = header(AP0, colorInteropID="lin_rec2020_scene", tag="lin_p3d65_scene")
    assert found(everything, "ACEScg") == ("lin_ap1_scene", "given: ACEScg", None)
    assert found(everything) == ("lin_rec2020_scene", "colorInteropID: lin_rec2020_scene", None)
    assert found(header(AP0, tag="lin_p3d65_scene")) == ("lin_p3d65_scene", "oiio:ColorSpace: lin_p3d65_scene", None)
    assert found(header(AP0)) == ("lin_ap0_scene", "chromaticities: lin_ap0_scene", None)
    assert found(header()) == ("lin_rec709", "no tag in the file: lin_rec709", None)
    assert found(header(), default="ACEScg") == ("lin_ap1_scene", "no tag in the file: lin_ap1_scene", None)


def test_encoded_files():
    assert found(header(tag="sRGB")) == ("lin_rec709", "oiio:ColorSpace: sRGB, brought to lin_rec709", "sRGB")
    assert found(header(colorInteropID="ocio:acescct_ap1_scene"))[::2] == ("lin_ap1_scene", "ocio:acescct_ap1_scene")
    assert found(header(), "ACEScct")[::2] == ("lin_ap1_scene", "ACEScct")
    assert found(header(), "ARRI LogC3 (EI800)")[::2] == ("lin_ap0_scene", "ARRI LogC3 (EI800)")


def test_pictures_to_be_looked_at_are_srgb():
    plain = found(header(), display_referred=True)
    assert plain == ("lin_rec709", "no tag in the file: sRGB", "srgb_rec709_scene")
    assert found(header(tag="lin_rec709_scene"), display_referred=True)[::2] == ("lin_rec709", None)
    assert found(header(), "lin_rec709", display_referred=True)[::2] == ("lin_rec709", None)


@pytest.mark.parametrize("tag", ["data", "raw", "Raw", "Utility - Raw"])
def test_data_counts_as_the_default(tag):
    name, how, encoding = found(header(AP0, tag=tag))
    assert (name, encoding) == ("lin_rec709", None)
    assert how == f"oiio:ColorSpace: {tag}, no colour: taken as lin_rec709"
    assert found(header(), tag, default="ACEScg")[0] == "lin_ap1_scene"


@pytest.mark.parametrize("tag", ["", "unknown"])
def test_tags_that_say_nothing(tag):
    assert found(header(AP0, colorInteropID=tag, tag=tag)) == found(header(AP0))


@pytest.mark.parametrize(
    "tag", ["my comp's space", "lin_rec70", "chromaticities(1,2)", "%s%n", "\t", "x" * 100_000, "é€"]
)
def test_tags_that_mean_nothing_are_passed_over_and_told(tag):
    name, how, _ = found(header(AP0, tag=tag))
    assert name == "lin_ap0_scene"
    assert "means nothing here" in how
    assert len(how) < 300
    assert found(header(tag=tag))[0] == "lin_rec709"


@pytest.mark.parametrize(
    "values",
    [(0.0,) * 8, (np.nan,) * 8, (np.inf,) * 8, (1e38,) * 8, AP0[:6], (*AP0, 0.5), (0.3127, 0.329) * 4],
)
def test_chromaticities_that_mean_nothing_are_passed_over_and_told(values):
    name, how, _ = found(header(values))
    assert (name, how) == ("lin_rec709", "no tag in the file: lin_rec709; its chromaticities are no colour space")


@pytest.mark.parametrize("value", ["none", 3, 1.5])
def test_attributes_of_another_type(value):
    assert found(header(colorInteropID=7, tag=1.5, chromaticities=None))[0] == "lin_rec709"
    spec = header()
    spec.attribute("chromaticities", value)
    assert found(spec)[0] == "lin_rec709"


def test_primaries_without_a_name():
    name, _how, encoding = found(header((1, 0, 0, 1, 0, 0, 1 / 3, 1 / 3)))
    assert name == "chromaticities(1,0,0,1,0,0,0.333333,0.333333)"
    assert encoding is None
    # Once tagged so, it is found again.
    assert found(header(tag=name))[0] == name


def test_what_oiio_before_3_1_says_of_every_exr(monkeypatch):
    monkeypatch.setattr(detection, "_OIIO_INVENTS_TAGS", True)
    assert found(header(AP0, tag="lin_rec709"))[0] == "lin_ap0_scene"
    assert found(header(tag="lin_rec709")) == ("lin_rec709", "no tag in the file: lin_rec709", None)
    assert found(header(AP0, tag="ACEScg"))[0] == "lin_ap1_scene"
    assert found(header(AP0, colorInteropID="lin_rec709_scene"))[0] == "lin_rec709"
    monkeypatch.setattr(detection, "_OIIO_INVENTS_TAGS", False)
    assert found(header(AP0, tag="lin_rec709"))[0] == "lin_rec709"


def test_an_exr_without_a_tag_gets_none(tmp_path):
    """The trap this leans on: what a header says of itself, and what a reader says of it."""
    path = str(tmp_path / "plain.exr")
    spec = header(AP0)
    out = oiio.ImageOutput.create(path)
    assert out.open(path, spec)
    assert out.write_image(np.zeros((2, 2, 3), np.float32))
    out.close()
    inp = oiio.ImageInput.open(path)
    assert found(inp.spec())[0] == "lin_ap0_scene"
    inp.close()


def test_given():
    space = color.space("ACEScg")
    assert found(header(AP0), space) == ("lin_ap1_scene", "given: lin_ap1_scene", None)
    assert found(header(AP0), "")[0] == "lin_ap0_scene"
    with pytest.raises(ColorError, match="'ACESgc'") as caught:
        color.detect(header(), "ACESgc")
    assert "ACEScg" in caught.value.hint
