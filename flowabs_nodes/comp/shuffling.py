"""Makes a picture of the channels of others, and of constants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from flowabs_nodes.comp.buffers import ALGO, buffer, done, pixels_of
from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import Image
from flowabs_nodes.port_types import pixel_type

#: The channels of a picture.
RGBA = ("R", "G", "B", "A")

#: From a channel of the result to the name of the channel that it is, or to a number.
Channels = Mapping[str, str | float]

EXPECTED = 'an object from R, G, B or A to the name of a channel, or to a number: {"R": "Z", "A": "other.A", "B": 0}'


def wrong_channels(value: Any) -> str | None:
    """Return what is wrong with a parameter of type :data:`Channels`; None where nothing is."""
    if not isinstance(value, dict):
        return EXPECTED
    for name, source in value.items():
        if name not in RGBA:
            return f"{EXPECTED}; found the channel {name!r}"
        number = isinstance(source, int | float) and not isinstance(source, bool) and math.isfinite(source)
        if not number and not (isinstance(source, str) and source):
            return f"{EXPECTED}; found {source!r} for {name}"
    return None


def shuffled(image: Image, other: Image | None, channels: Channels) -> Image:
    """Return a color image whose channels are those named.

    A name is a channel of ``image``, "other.NAME" one of ``other``, "image.NAME" one of ``image`` whatever it is
    called. A channel that ``channels`` does not name is the image's of that name; R, G and B of a mono or a matte are
    its one channel. R, G and B that the image has not are 0, A is left out. Colours are not multiplied by another
    alpha than they were.

    Raises
    ------
    ArgumentError
        There is no such channel, with the nearest name.
    """
    sources = _named(image) | {f"image.{name}": at for name, at in _named(image).items()}
    stacked = image.pixels
    if other is not None:
        count = stacked.shape[2]
        sources |= {f"other.{name}": at + count for name, at in _named(other).items()}
        stacked = np.concatenate([stacked, other.pixels], axis=2)
    order = []
    names = [name for name in RGBA if name != "A" or name in channels or name in sources]
    for name in names:
        source = channels.get(name, name if name in sources else 0.0)
        order.append(_place(source, sources, other is not None, name) if isinstance(source, str) else float(source))
    result = done(ALGO.channels, buffer(stacked), tuple(order), tuple(names))
    return image.with_pixels(pixels_of(result), "color")


def _named(image: Image) -> dict[str, int]:
    """Return the index of each channel by its name; R, G and B of a mono or a matte are its only one."""
    grey = dict.fromkeys(RGBA[:3], 0) if "color" in pixel_type(image.type).widens_to else {}
    return grey | {name: i for i, name in enumerate(image.channels)}


def _place(source: str, sources: Mapping[str, int], has_other: bool, name: str) -> int:
    """Return the index of the channel ``source`` for the channel ``name`` of the result."""
    if source in sources:
        return sources[source]
    hint = "connect the input other" if source.startswith("other.") and not has_other else nearest(source, sources)
    raise ArgumentError(f"there is no channel {source!r} for {name}", hint=hint, parameter="channels")
