"""Scene-linear spaces by their names."""

from __future__ import annotations

import pytest

from flowabs_nodes.color.lookup import space
from flowabs_nodes.color.spaces import KNOWN
from flowabs_nodes.errors import ColorError


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("lin_rec709", "lin_rec709"),
        ("LIN_REC709_SCENE", "lin_rec709"),
        ("linear", "lin_rec709"),
        ("ACEScg", "lin_ap1_scene"),
        ("aces", "lin_ap0_scene"),
        ("Linear Rec.2020", "lin_rec2020_scene"),
    ],
)
def test_names_and_aliases_in_any_case(name: str, found: str) -> None:
    assert space(name) is KNOWN[found]


def test_a_space_is_returned_as_it_is() -> None:
    ours = KNOWN["lin_p3d65_scene"]
    assert space(ours) is ours


def test_chromaticities_are_a_name() -> None:
    assert space("chromaticities(0.64,0.33,0.3,0.6,0.15,0.06,0.3127,0.329)") is KNOWN["lin_rec709"]
    other = space("chromaticities(0.6,0.33,0.3,0.6,0.15,0.06,0.3127,0.329)")
    assert space(other.name) == other


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("lin_rec790", "no colour space 'lin_rec790'"),
        ("ACEScct", "not scene-linear"),
        ("sRGB", "not scene-linear"),
        ("raw", "holds data"),
        ("", "not the name of a colour space"),
    ],
)
def test_other_names_are_errors(name: str, message: str) -> None:
    with pytest.raises(ColorError, match=message):
        space(name)


def test_the_hint_is_the_nearest_name() -> None:
    with pytest.raises(ColorError) as error:
        space("lin_rec790")
    assert "lin_rec709" in str(error.value.hint)
