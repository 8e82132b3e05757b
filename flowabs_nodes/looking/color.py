"""Look at a colour image through the view transform of the OCIO config, over black."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.color import ocio as named_spaces
from flowabs_nodes.color.display import SRGB, DisplayView, displays, find_view, to_display, views
from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look


def look_at_color(image: Image, ocio: str | None = None) -> Look:
    """Return scene-linear, premultiplied colour as the config's default display and view show it, over black.

    A config without any is seen as plain sRGB. Raises ColorError where the config cannot be read or used.
    """
    rgb, alpha = image.pixels[..., :3], image.alpha
    if alpha is not None:
        rgb = np.divide(rgb, alpha[..., None], out=rgb.copy(), where=alpha[..., None] > 0)
    shown_by = _default(ocio)
    if shown_by is None:
        linear = np.nan_to_num(rgb, nan=0.0, posinf=1e30, neginf=-1e30)
        look = Look(
            named_spaces.encode_named(linear, image.colorspace, SRGB),
            "colour as plain sRGB: the OCIO config has no display with a view",
        )
    else:
        look = Look(
            to_display(rgb, image.colorspace, shown_by, ocio),
            f"colour through the view {shown_by.view!r} of the display {shown_by.display!r}",
            shown_by.encoding or SRGB,
        )
    if alpha is None:
        return look
    return Look(look.codes * alpha[..., None].clip(0, 1), f"{look.said}, over black", look.encoding)


def _default(ocio: str | None) -> DisplayView | None:
    """Return the config's default display and view; None where it has none."""
    known = displays(ocio)
    return find_view(ocio=ocio) if known and views(known[0], ocio) else None
