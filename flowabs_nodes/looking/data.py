"""Look at data: channels of any meaning, stretched from the least to the greatest value."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.image import Image
from flowabs_nodes.looking.look import Look
from flowabs_nodes.looking.stretch import finite_range, grey, stretched

#: Last parts of the names of channels that belong together, and share one range.
_TRIPLES = ({"R", "G", "B"}, {"X", "Y", "Z"}, {"x", "y", "z"}, {"r", "g", "b"})


def look_at_data(image: Image) -> Look:
    """Return up to three channels as red, green, blue, a single one as grey: each from its least to its greatest value.

    R, G, B and X, Y, Z share one range, so that their proportions stay.
    """
    names = image.channels
    shown = _triple(names) or list(range(min(3, len(names))))
    planes = [image.pixels[..., index] for index in shown]
    called = [names[index] for index in shown]
    others = len(names) - len(shown)
    left_out = f"; {others} more {'channel is' if others == 1 else 'channels are'} not shown" if others else ""
    if _triple(names):
        low, high = finite_range(np.stack(planes))
        codes = np.stack([stretched(plane, low, high) for plane in planes], axis=2)
        return Look(codes, f"data {', '.join(called)} from {low:.4g} to {high:.4g} as red, green, blue{left_out}")
    ranges = [finite_range(plane) for plane in planes]
    greys = [stretched(plane, *limits) for plane, limits in zip(planes, ranges, strict=True)]
    spans = [f"{name} from {low:.4g} to {high:.4g}" for name, (low, high) in zip(called, ranges, strict=True)]
    if len(greys) == 1:
        return Look(grey(greys[0]), f"data {spans[0]}, black to white{left_out}")
    greys += [np.zeros_like(greys[0])] * (3 - len(greys))
    colors = ("red", "green", "blue")[: len(spans)]
    said = ", ".join(f"{span} as {color}" for span, color in zip(spans, colors, strict=True))
    return Look(np.stack(greys, axis=2), f"data {said}{left_out}")


def _triple(names: tuple[str, ...]) -> list[int]:
    """Return the places of three channels of one layer that belong together, in order; none where there are not."""
    layers: dict[str, dict[str, int]] = {}
    for index, name in enumerate(names):
        layer, _, last = name.rpartition(".")
        layers.setdefault(layer, {})[last] = index
    for channels in layers.values():
        for triple in _TRIPLES:
            if triple <= channels.keys():
                return [channels[last] for last in sorted(triple, key="RGBrgbXYZxyz".index)]
    return []
