"""Pixels that become NaN or Inf by a space: an error that names the space, how many, and the first."""

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color.cicp import read_cicp
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.icc import read_profile
from flowabs_nodes.color.transfers import Power
from flowabs_nodes.errors import ColorError
from tests.color import profiles
from tests.studio import STUDIO, studio

REC709 = color.space("lin_rec709")
P22 = Power(2.2)

#: Names of each family of transfer functions, and codes that leave float32.
DECODED = {
    "sRGB": 1e30,
    "cineon": 1e3,
    "ACEScct": 100.0,
    "ARRI LogC3 (EI800)": 100.0,
    "ARRI LogC4": 100.0,
    "V-Log V-Gamut": 100.0,
    "Log3G10 REDWideGamutRGB": 100.0,
    "S-Log3 S-Gamut3": 65504.0,
    "DaVinci Intermediate WideGamut": 100.0,
    "g22_rec709_scene": 1e30,
    "camera_rec709": 1e30,
    "sRGB - Display": 1e30,
}


def plate(value, count=1):
    """Return a grey picture with ``count`` pixels of a value, the first at x 2, y 1."""
    pixels = np.full((3, 4, 3), 0.25, np.float32)
    pixels.reshape(-1, 3)[6 : 6 + count] = value
    return pixels


def refused(call, name, count, value):
    with pytest.raises(ColorError) as caught:
        call()
    message = str(caught.value)
    assert caught.value.code == "non-finite"
    pixels = "1 pixel becomes" if count == 1 else f"{count} pixels become"
    assert f"{name!r}, {pixels} NaN or Inf, the first at x 2, y 1: {np.float32(value):.6g}" in message


@pytest.mark.parametrize(("name", "value"), DECODED.items())
@pytest.mark.parametrize("count", [1, 3])
def test_codes_of_every_family(name, value, count):
    refused(lambda: color.ocio.linearize(plate(value, count), name), name, count, value)
    assert np.isfinite(color.ocio.linearize(plate(0.5), name)[0]).all()


def test_codes_of_a_studio(tmp_path):
    path = studio(tmp_path)
    refused(lambda: color.ocio.linearize(plate(65504), "show_log", path), "show_log", 1, 65504)


DESCRIBED = {
    "gamma": Encoding("gamma 2.2", REC709, (P22, P22, P22)),
    "ICC": read_profile(profiles.profile("sRGB"), "own"),
    "PQ": read_cicp([9, 16, 0, 1]),
    "HLG": read_cicp([9, 18, 0, 1]),
}


def finite_or_refused(call, what):
    """Check that what ``call`` returns is finite, or that it raises the error for the plate's one pixel."""
    try:
        result = call()
    except ColorError as error:
        found = error
    else:
        assert np.isfinite(result).all()
        return
    assert found.code == "non-finite"
    assert f"{what}, 1 pixel becomes NaN or Inf, the first at x 2, y 1" in str(found)


@pytest.mark.parametrize("encoding", DESCRIBED.values(), ids=DESCRIBED)
@pytest.mark.parametrize("value", [1.5, 100.0, 65504.0, 1e30, 3e38, -1.0, -65504.0, -3e38])
def test_codes_that_a_file_describes_are_finite_or_refused(encoding, value):
    finite_or_refused(lambda: color.ocio.linearize(plate(value), encoding)[0], f"decoded from {encoding.name!r}")


def test_codes_that_a_file_describes_can_be_refused():
    refused(lambda: color.ocio.linearize(plate(1e30), DESCRIBED["gamma"]), "gamma 2.2", 1, 1e30)


@pytest.mark.parametrize("encoding", [*DESCRIBED.values(), *DECODED], ids=[*DESCRIBED, *DECODED])
@pytest.mark.parametrize("value", [1.5, 65504.0, 1e30, 3e38, -1.0, -65504.0, -3e38])
def test_what_is_encoded_is_finite_or_refused(encoding, value):
    for space in (REC709, color.space("lin_p3d65_scene")):
        finite_or_refused(
            lambda space=space: color.ocio.encode_named(plate(value), space, encoding), f"encoded as {str(encoding)!r}"
        )


def test_encoding_to_a_space_that_cannot_hold_it(tmp_path):
    refused(lambda: color.ocio.encode_named(plate(3e38), REC709, "steep", steep(tmp_path)), "steep", 1, 3e38)


def steep(folder):
    """Return a config with a space whose codes are the square of light."""
    space = "  - !<ColorSpace>\n    name: steep\n    from_scene_reference: !<ExponentTransform> {value: 2}\n"
    return studio(folder, text=STUDIO + space)


def test_between_linear_spaces():
    pixels = plate(0)
    pixels[1, 2] = (3e38, -3e38, 0)
    with pytest.raises(ColorError, match=r"'lin_rec709', 1 pixel becomes NaN or Inf, the first at x 2, y 1: 3e\+38"):
        color.ocio.encode_named(pixels, color.space("ACES2065-1"), "lin_rec709")


def test_nan_that_was_there_before_is_nobodys_fault():
    pixels = plate(np.nan)
    assert np.isnan(color.ocio.linearize(pixels, "sRGB")[0][1, 2]).all()
