"""What the numbers of a host's picture mean."""

from __future__ import annotations

from typing import Any

import pytest

from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.image.numbers import meaning


@pytest.mark.parametrize(
    ("said", "floats", "expected"),
    [
        ((None, None, None), True, ("lin_rec709", None, False, False, "lin_rec709")),
        ((None, None, None), False, ("lin_rec709", None, True, False, "lin_rec709")),
        (("ACEScg", None, None), True, ("lin_ap1_scene", None, False, False, "lin_ap1_scene")),
        (("sRGB", None, None), True, ("lin_rec709", "sRGB", True, True, "lin_rec709")),
        (("ACEScct", None, None), True, ("lin_ap1_scene", "ACEScct", True, True, "lin_ap1_scene")),
        ((None, "ACEScct", None), True, ("lin_ap1_scene", "ACEScct", True, True, "lin_ap1_scene")),
        (("lin_rec709", "ACEScct", None), True, ("lin_ap1_scene", "ACEScct", True, True, "lin_rec709")),
        (("ACEScg", "linear", None), True, ("lin_ap1_scene", None, False, True, "lin_ap1_scene")),
        ((None, "linear", None), False, ("lin_rec709", None, True, True, "lin_rec709")),
        (("ACEScg", "lin_rec709", "straight"), True, ("lin_rec709", None, True, True, "lin_ap1_scene")),
        ((None, "sRGB", "premultiplied"), False, ("lin_rec709", "sRGB", False, True, "lin_rec709")),
    ],
)
def test_encoding_is_what_the_numbers_are_and_colorspace_what_the_image_is_kept_in(
    said: Any, floats: bool, expected: Any
) -> None:
    found = meaning(*said, floats=floats)
    assert (found.space.name, found.encoding, found.straight, found.scaled, found.kept.name) == expected


@pytest.mark.parametrize(
    ("said", "error", "parameter", "message"),
    [
        (("sRBG", None, None), ColorError, "colorspace", "no colour space 'sRBG'.*did you mean"),
        ((None, "sRGBB", None), ColorError, "encoding", "no colour space 'sRGBB'"),
        (("sRGB", "ACEScct", None), ColorError, "colorspace", "'sRGB' is not scene-linear"),
        (("sRGB", "linear", None), ColorError, "colorspace", "'sRGB' is not scene-linear"),
        ((None, 7, None), ArgumentError, "encoding", "expected a name such as"),
        ((None, "", None), ArgumentError, "encoding", "found ''"),
        ((None, None, "unpremultiplied"), ArgumentError, "alpha", "found 'unpremultiplied' .did you mean"),
    ],
)
def test_what_is_said_wrongly_is_named(said: Any, error: Any, parameter: str, message: str) -> None:
    with pytest.raises(error, match=message) as found:
        meaning(*said, floats=True)
    assert found.value.parameter == parameter
