"""Code points of ITU-T H.273 mean their primaries and transfer functions; those of BT.2100 have diffuse white at 1."""

from __future__ import annotations

import pytest

from flowabs_nodes.color.cicp import read_cicp
from flowabs_nodes.color.transfers import SRGB, Hlg, Power, Pq
from flowabs_nodes.errors import ColorError


@pytest.mark.parametrize(
    ("codes", "space", "transfer"),
    [
        ((9, 16, 0, 1), "lin_rec2020_scene", Pq()),
        ((9, 18, 0, 1), "lin_rec2020_scene", Hlg()),
        ((12, 13, 0, 1), "lin_p3d65_scene", SRGB),
        ((12, 16, 0, 1), "lin_p3d65_scene", Pq()),
        ((1, 13, 0, 1), "lin_rec709", SRGB),
        ((1, 8, 0, 1), "lin_rec709", Power(1.0)),
        ((9, 14, 0, 1), "lin_rec2020_scene", Power(2.4)),
        ((1, 4, 0, 1), "lin_rec709", Power(2.2)),
    ],
)
def test_code_points(codes: tuple[int, ...], space: str, transfer: object) -> None:
    found = read_cicp(codes)
    assert (found.space.name, found.transfers[0], found.cicp) == (space, transfer, codes)


@pytest.mark.parametrize("primaries", [4, 5, 6, 7, 8, 11, 22])
def test_other_primaries_are_spaces_of_their_own(primaries: int) -> None:
    assert read_cicp((primaries, 13, 0, 1)).space.name.startswith("chromaticities(")


@pytest.mark.parametrize("codes", [(2, 2, 0, 1), (9, 99, 0, 1), (99, 13, 0, 1), (9, 16, 9, 1), (1, 13, 0, 0)])
def test_what_is_not_known_says_so(codes: tuple[int, ...]) -> None:
    with pytest.raises(ColorError, match=r"not known|full range"):
        read_cicp(codes)
