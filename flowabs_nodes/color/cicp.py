"""Know the code points of ITU-T H.273 (CICP), by which PNG and video name primaries and transfer functions."""

from __future__ import annotations

from collections.abc import Sequence

from flowabs_nodes.color.chromaticities import space_from_chromaticities
from flowabs_nodes.color.encoding import Encoding, Transfer
from flowabs_nodes.color.spaces import KNOWN, ColorSpace
from flowabs_nodes.color.transfers import SRGB, Hlg, Power, Pq
from flowabs_nodes.errors import ColorError

#: Primaries that are no known space: CIE x, y of red, green, blue and white (H.273, table 2).
_D65, _C = (0.3127, 0.3290), (0.310, 0.316)
_PRIMARIES = {
    4: ((0.67, 0.33), (0.21, 0.71), (0.14, 0.08), _C),
    5: ((0.64, 0.33), (0.29, 0.60), (0.15, 0.06), _D65),
    6: ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070), _D65),
    7: ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070), _D65),
    8: ((0.681, 0.319), (0.243, 0.692), (0.145, 0.049), _C),
    11: ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060), (0.314, 0.351)),
    22: ((0.630, 0.340), (0.295, 0.605), (0.155, 0.077), _D65),
}
_KNOWN = {1: "lin_rec709", 9: "lin_rec2020_scene", 12: "lin_p3d65_scene"}

#: Transfer functions (H.273, table 3). That of video, made to be looked at, is a display's: ITU-R BT.1886.
_TRANSFERS: dict[int, Transfer] = {
    **dict.fromkeys((1, 6, 14, 15), Power(2.4)),
    4: Power(2.2),
    5: Power(2.8),
    8: Power(1.0),
    13: SRGB,
    16: Pq(),
    17: Power(2.6),
    18: Hlg(),
}


def read_cicp(codes: Sequence[int]) -> Encoding:
    """Return the encoding of four code points: primaries, transfer function, matrix, full range.

    Diffuse white becomes 1: 203 cd/m2 of PQ, the code .75 of HLG (ITU-R BT.2408). Raises ColorError for code points
    that are not known, and for pixels that are not RGB of full range.
    """
    primaries, transfer, matrix, full = (int(code) for code in codes)
    if matrix != 0 or full != 1:
        raise ColorError("its pixels are not RGB of full range", code="bad-cicp")
    if transfer not in _TRANSFERS or (primaries not in _KNOWN and primaries not in _PRIMARIES):
        raise ColorError("these code points are not known", code="bad-cicp")
    curve = _TRANSFERS[transfer]
    name = f"cICP {primaries}, {transfer}"
    return Encoding(name, _space(primaries), (curve, curve, curve), cicp=(primaries, transfer, matrix, full))


def _space(primaries: int) -> ColorSpace:
    """Return the scene-linear space of a code point."""
    if primaries in _KNOWN:
        return KNOWN[_KNOWN[primaries]]
    return space_from_chromaticities(*_PRIMARIES[primaries])
