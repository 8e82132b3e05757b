"""Look at scene-linear colours as a viewer shows them: by a display and a view of the OCIO config.

A display is a kind of screen ("sRGB - Display"), a view how a scene is brought to it ("ACES 1.0 - SDR Video": tone
mapped as film). Here "" and "default" both stand for what the config names first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import config
from flowabs_nodes.color.cicp import read_cicp
from flowabs_nodes.color.config import Config, Ocio
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.named import DATA_NAMES, SRGB_NAMES
from flowabs_nodes.color.spaces import KNOWN, ColorSpace, convert
from flowabs_nodes.errors import ColorError

#: The encoding of a display of sRGB.
SRGB = "srgb_rec709_scene"

#: The word for what the config names first.
DEFAULT = "default"

#: What a config says of a view whose colour space has the display's name; OpenImageIO 3.0 gives it as it stands there.
_OF_THE_DISPLAY = "<USE_DISPLAY_NAME>"

#: Light beyond this, the greatest half, and Inf, count as this: tables of views end far below.
_MOST = 65504.0

#: The Color Interop Forum's names of displays, under the names and aliases that configs have for their colour space.
_INTEROP_IDS = {
    **dict.fromkeys((*SRGB_NAMES, "srgb_rec709_display"), "srgb_rec709_display"),
    **dict.fromkeys(("display p3 - display", "displayp3_display", "srgb_p3d65_display"), "srgb_p3d65_display"),
    **dict.fromkeys(("rec.1886 rec.709 - display", "rec1886_rec709_display"), "g24_rec709_display"),
    **dict.fromkeys(("rec.1886 rec.2020 - display", "rec1886_rec2020_display"), "g24_rec2020_display"),
    **dict.fromkeys(("rec.2100-hlg - display", "rec2100_hlg_display"), "hlg_rec2020_display"),
    **dict.fromkeys(("rec.2100-pq - display", "rec2100_pq_display"), "pq_rec2020_display"),
    **dict.fromkeys(("st2084-p3-d65 - display", "st2084_p3d65_display"), "pq_p3d65_display"),
    **dict.fromkeys(("p3-d65 - display", "p3d65_display"), "g26_p3d65_display"),
}
_INTEROP_IDS |= {name: name for name in _INTEROP_IDS.values()}

#: Their primaries and transfer functions as code points of ITU-T H.273, for RGB of full range.
_CICP = {
    "srgb_p3d65_display": (12, 13, 0, 1),
    "g24_rec709_display": (1, 1, 0, 1),
    "g24_rec2020_display": (9, 14, 0, 1),
    "hlg_rec2020_display": (9, 18, 0, 1),
    "pq_rec2020_display": (9, 16, 0, 1),
    "pq_p3d65_display": (12, 16, 0, 1),
    "g26_p3d65_display": (12, 17, 0, 1),
}


@dataclass(frozen=True)
class DisplayView:
    """A display and a view of a config, by their names there.

    Attributes
    ----------
    display, view
        The config's own names.
    data
        True for a view that shows numbers as they are, such as "Raw".
    interop_id
        The Color Interop Forum's name of what the codes of the display are; "" where it is not known, or ``data``.
    """

    display: str
    view: str
    data: bool = False
    interop_id: str = ""

    def __str__(self) -> str:
        return f"{self.display}, {self.view}"

    @property
    def encoding(self) -> str | Encoding | None:
        """Return the encoding of the display's codes, an OCIO name or code points; None where it is not known."""
        if self.interop_id in _CICP:
            return replace(read_cicp(_CICP[self.interop_id]), name=self.display)
        return SRGB if self.interop_id else None


def displays(ocio: Ocio = None) -> list[str]:
    """Return the names of the config's displays, its default first."""
    found = config.config(ocio)
    first = str(found.getDefaultDisplayName())
    names = [str(name) for name in found.getDisplayNames()]
    return sorted(names, key=lambda name: name != first)


def views(display: str, ocio: Ocio = None) -> list[str]:
    """Return the names of a display's views, its default first."""
    found = config.config(ocio)
    first = str(found.getDefaultViewName(display))
    names = [str(name) for name in found.getViewNames(display)]
    return sorted(names, key=lambda name: name != first)


def find_view(display: str = DEFAULT, view: str = DEFAULT, ocio: Ocio = None) -> DisplayView:
    """Return a display and a view of the config.

    Raises
    ------
    ColorError
        unknown-display or unknown-view, with what the config has and the nearest name; bad-ocio-config for a config
        that cannot be read.
    """
    found = config.opened(ocio)
    chosen = _chosen("display", display, displays(found), found)
    return _described(chosen, _chosen("view", view, views(chosen, found), found, f" for the display {chosen!r}"), found)


def _chosen(kind: str, name: str, known: list[str], ocio: Config, of: str = "") -> str:
    """Return the config's own name of a display or view, in any case; raise ColorError where it has none."""
    if name in ("", DEFAULT) and known:
        return known[0]
    found = next((each for each in (name, *known) if each in known and each.lower() == name.lower()), None)
    if found is None:
        said = f"it has {', '.join(map(repr, known))}" if known else f"it has no {kind}s"
        raise ColorError(
            f"the OCIO config {ocio.name} has no {kind} {name!r}{of}: {said}",
            code=f"unknown-{kind}",
            hint=config.hint(name, known) or _part_of(name, known),
        )
    return found


def _part_of(name: str, known: list[str]) -> str:
    """Return a hint with the first name that has ``name`` in it: "sRGB - Display" for "sRGB"; else ""."""
    longer = next((each for each in known if name.lower() in each.lower()), None)
    return f"did you mean {longer!r}?" if longer else ""


@cache
def _described(display: str, view: str, ocio: Config) -> DisplayView:
    """Return what is known of a display and view that the config has."""
    found = config.config(ocio)
    space = str(found.getDisplayViewColorSpaceName(display, view)).replace(_OF_THE_DISPLAY, display)
    if space.lower() in DATA_NAMES or config.is_data(space, ocio):
        return DisplayView(display, view, data=True)
    names = [space, *map(str, found.getAliases(space)), display]
    known = (_INTEROP_IDS[name.lower()] for name in names if name.lower() in _INTEROP_IDS)
    return DisplayView(display, view, interop_id=next(known, ""))


def to_display(rgb: Array, colorspace: ColorSpace, chosen: DisplayView, ocio: Ocio = None) -> Array:
    """Return the codes, (H, W, 3) float32, black 0 and white 1, by which a display shows scene-linear colours.

    ``rgb`` is (H, W, 3) float32 of ``colorspace``, not premultiplied; NaN counts as 0, and what lies beyond half as the
    greatest half. A view of data changes nothing. Raises ColorError where the config cannot do it.
    """
    if chosen.data:
        return rgb
    theirs, ours = config.reference(ocio)
    finite = np.nan_to_num(rgb, nan=0.0, posinf=_MOST, neginf=-_MOST).clip(-_MOST, _MOST)
    buf = oiio.ImageBuf(np.ascontiguousarray(convert(finite, colorspace, KNOWN[ours])))
    shown = oiio.ImageBufAlgo.ociodisplay(
        buf, chosen.display, chosen.view, theirs, unpremult=False, colorconfig=config.opened(ocio).path
    )
    if shown.has_error:
        problem = config.said(shown.geterror)
        raise ColorError(f"the view {chosen.view!r} of {chosen.display!r} fails: {problem}", code="bad-view")
    codes = np.asarray(shown.get_pixels(oiio.FLOAT), np.float32).reshape(rgb.shape)
    return np.asarray(np.nan_to_num(codes, nan=0.0), np.float32)
