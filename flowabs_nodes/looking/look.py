"""Hold a picture to look at: its codes, and a sentence that says how it shows the numbers."""

from __future__ import annotations

from dataclasses import dataclass

from flowabs_nodes.array_types import Array
from flowabs_nodes.color.display import SRGB
from flowabs_nodes.color.encoding import Encoding


@dataclass(frozen=True)
class Look:
    """A picture of an image.

    Attributes
    ----------
    codes
        (H, W, 3) float32, what a screen is sent: 0 black, 1 white.
    said
        How the codes show the image's numbers, for the person who looks: "depth 2.5 (white) to 40 (dark), ...".
    encoding
        The encoding of the codes, an OCIO name or code points.
    """

    codes: Array
    said: str
    encoding: str | Encoding = SRGB
