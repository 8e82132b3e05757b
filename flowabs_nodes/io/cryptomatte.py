"""Read Cryptomattes: which id covers most of each pixel, and how much of it.

A Cryptomatte is a stack of layers: "name00", "name01" ... Each has four channels: an id and its coverage, the next id
and its coverage, sorted by coverage. An id is the 32 bits of a float. The header says ``cryptomatte/KEY/name`` and, as
``cryptomatte/KEY/manifest``, the names of the ids (Psyop's Cryptomatte specification).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.image_file import PictureFile
from flowabs_nodes.io.layer_groups import Layer
from flowabs_nodes.io.layers import Selection, check_windows

_PREFIX = "cryptomatte/"
_LEVEL = re.compile(r"(.*)(\d\d)")


class Ids(NamedTuple):
    """The id of each pixel, (H, W) uint32, and the part of the pixel that it covers, (H, W) float32."""

    ids: npt.NDArray[np.uint32]
    coverage: Array


def declared(specs: Sequence[oiio.ImageSpec]) -> dict[str, dict[str, Any]]:
    """Return the header's attributes of each Cryptomatte, by its name; whichever part they stand in."""
    by_key: dict[str, dict[str, Any]] = {}
    for spec in specs:
        for attribute in spec.extra_attribs:
            if attribute.name.startswith(_PREFIX):
                key = attribute.name[len(_PREFIX) :].partition("/")[0]
                by_key.setdefault(key, {}).setdefault(attribute.name, attribute.value)
    return {str(found.get(f"{_PREFIX}{key}/name", key)): found for key, found in by_key.items()}


def base_name(layer: str) -> str:
    """Return the name of a layer's Cryptomatte: "ViewLayer.CryptoObject" of "ViewLayer.CryptoObject01"."""
    level = _LEVEL.fullmatch(layer)
    return level[1] if level else layer


def first_level(layer: Layer) -> tuple[str, ...] | None:
    """Return the four channels of a Cryptomatte's first level; None for any other layer."""
    return layer.vector(4) if layer.base.endswith("00") else None


def majority(file: PictureFile, layers: Iterable[Layer], chosen: Selection) -> Ids:
    """Return what covers most of each pixel of the Cryptomatte whose first level is ``chosen``.

    The background, id 0, has what all ids of all levels leave of a pixel, and wins where that is more than the first id
    has. Raises ReadError where the channels are not 32-bit floats, which alone keep ids.
    """
    layers = list(layers)
    first = next(layer for layer in layers if (layer.part, layer.name) == (chosen.part, chosen.layer))
    base = base_name(first.base)
    further = [
        Selection(layer.part, layer.name, channels)
        for layer in layers
        if (base_name(layer.base), layer.view) == (base, first.view)
        and layer.base not in (base, first.base)
        and (channels := layer.vector(4))
    ]
    check_windows(file.specs, [chosen, *further])
    planes: dict[str, npt.NDArray[Any]] = {}
    for part in dict.fromkeys(level.part for level in (chosen, *further)):
        names = [name for level in (chosen, *further) if level.part == part for name in level.channels]
        planes |= file.read_native(part, names)
    ids, covered, total = _level(planes, chosen.channels)
    for level in further:
        total = total + _level(planes, level.channels)[2]
    rest = 1 - total
    background = rest > covered
    return Ids(np.where(background, np.uint32(0), ids), np.where(background, rest, covered))


def _level(
    planes: Mapping[str, npt.NDArray[Any]], channels: Sequence[str]
) -> tuple[npt.NDArray[np.uint32], Array, Array]:
    """Return the first id of a level, its coverage, and the coverage of both ids of the level, each (H, W)."""
    ids, first, _, second = (planes[name] for name in channels)
    if ids.dtype != np.float32:
        raise ReadError(f"{channels[0]} is {ids.dtype}: the ids of a Cryptomatte are 32-bit floats", code="wrong-layer")
    first, second = np.asarray(first, np.float32), np.asarray(second, np.float32)
    return ids.view(np.uint32), first, first + second
