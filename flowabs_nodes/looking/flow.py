"""Look at a flow: its orientation as colour, its streamlines as streaks."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.filters.flow.flow_color import flow_color
from flowabs_nodes.filters.flow.lic import lic
from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look

#: The streaks' length in a picture whose shorter side is this long; a larger picture has longer ones.
_LENGTH, _SHORTER = 20.0, 540

#: What the LIC, whose mean is 1/2, is multiplied by, so that colours keep most of their light.
_LIGHT = 1.5


def look_at_flow(image: Image) -> Look:
    """Return the colours of the orientations (Fig. 5 of the paper) times the LIC (Fig. 3); NaN and Inf count as 0."""
    window = image.display_window
    length = _LENGTH * max(1.0, min(window.width, window.height) / _SHORTER)
    tangents = np.nan_to_num(image.pixels, nan=0.0, posinf=0.0, neginf=0.0)
    streaks = lic(tangents, length=min(length, 20_000))
    codes = (flow_color(tangents) * (_LIGHT * streaks[..., None])).clip(0, 1)
    return Look(codes, "colour is orientation (horizontal red, vertical cyan), streaks follow it (LIC)")
