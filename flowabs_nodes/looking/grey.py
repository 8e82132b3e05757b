"""Look at a matte or a mono image as grey."""

from __future__ import annotations

from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look
from flowabs_nodes.looking.stretch import finite_range, grey, stretched

#: A few pixels of a response may be much stronger than all others.
_PERCENTILES = (0.5, 99.5)


def look_at_grey(image: Image) -> Look:
    """Return one channel as it is, 0 black and 1 white; a mono with other values stretched by percentiles.

    A matte's values beyond 0 and 1 are cut off.
    """
    values = image.pixels[..., 0]
    low, high = finite_range(values)
    if image.type == "matte" or (low >= 0 and high <= 1):
        return Look(grey(stretched(values, 0, 1)), f"{image.type} as it is: 0 black, 1 white")
    black, white = finite_range(values, _PERCENTILES)
    if black == white:  # nearly all of one value
        black, white = low, high
    said = f"{image.type} from {black:.4g} (black) to {white:.4g} (white), of values from {low:.4g} to {high:.4g}"
    return Look(grey(stretched(values, black, white)), said)
