"""Find the layers of a render pass by the names that renderers give them, or by the name that somebody asks for.

Pure functions on ImageSpecs. Which names are usual is said once, at :data:`DEPTH` and the constants below it. They are
compared without the view layer before the last dot, without "VRay" in front, and without case, spaces and underscores:
"ViewLayer.Depth", "VRayZDepth", "Z Depth" and "z_depth" are "depth", "zdepth", "zdepth" and "zdepth".
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, nearest
from flowabs_nodes.io.layers import Selection, few, listing, part_name, parts_to_read


class Names(NamedTuple):
    """The usual names of a pass, the best first, as :func:`plain_name` gives them; and what its channels are."""

    what: str
    usual: tuple[str, ...]
    channels: str


DEPTH = Names(
    "depth",
    ("depth", "z", "zdepth", "pz"),  # Blender, Karma; OpenEXR, Arnold, RenderMan; V-Ray; Mantra
    "one channel, such as Z",
)
NORMAL = Names(
    "normals",
    ("normal", "n", "nn", "normals"),  # Blender; Arnold, Karma; RenderMan; V-Ray
    "X, Y, Z or R, G, B",
)
MOTION = Names(
    "motion",
    ("vector", "motion", "motionvector", "motionvectors", "velocity"),  # Blender; ours; Arnold, Karma; V-Ray
    "X, Y, Z, W, or X, Y, or R, G, or u, v",
)
#: Motion in a layer for each way: RenderMan's and Nuke's.
MOTION_FORWARD = MOTION._replace(usual=("motionfore", "forward"))
MOTION_BACKWARD = MOTION._replace(usual=("motionback", "backward"))
ID = Names(
    "ids",
    # Arnold, RenderMan, ours; Blender 5, 4.5; V-Ray; Karma; and materials: Blender 5, 4.5, V-Ray
    ("id", "objectindex", "indexob", "objectid", "renderid", "primid", "materialindex", "indexma", "mtlid"),
    "one channel of whole numbers, or a Cryptomatte",
)
CRYPTOMATTE = Names(
    "ids",
    ("cryptoobject00", "cryptomatte00"),  # Blender, Arnold; V-Ray
    "R, G, B, A",
)

#: Names that files use for the components of a vector.
_VECTORS = (
    ("X", "Y", "Z", "W"),
    ("x", "y", "z", "w"),
    ("R", "G", "B", "A"),
    ("r", "g", "b", "a"),
    ("red", "green", "blue", "alpha"),
    ("u", "v"),
)


class Layer(NamedTuple):
    """Channels of one part that belong together; ``channels`` maps the last part of each name to the whole name."""

    part: int
    name: str
    channels: dict[str, str]

    def vector(self, count: int) -> tuple[str, ...] | None:
        """Return the names of the first ``count`` components, X or R first; None where the layer has not so many."""
        for family in _VECTORS:
            if len(family) >= count and set(family[:count]) <= set(self.channels):
                return tuple(self.channels[each] for each in family[:count])
        return None

    def single(self) -> tuple[str, ...] | None:
        """Return the name of the only channel, or of the Z beside others; all three of a grey R, G, B; else None."""
        if len(self.channels) == 1:
            return tuple(self.channels.values())
        depth = next((self.channels[each] for each in ("Z", "z") if each in self.channels), None)
        if depth is not None:
            return None if self.vector(2) else (depth,)
        return self.vector(3)


#: Chooses the channels of a layer, None where they do not fit the pass.
Pick = Callable[[Layer], tuple[str, ...] | None]


def plain_name(layer: str) -> str:
    """Return a layer's name as usual names are compared: "depth" for "ViewLayer.Depth", "zdepth" for "VRayZDepth"."""
    last = layer.rpartition(".")[2].lower()
    return "".join(letter for letter in last if letter.isalnum()).removeprefix("vray") or last


def layers_of(specs: Sequence[oiio.ImageSpec], part: str | int = "") -> list[Layer]:
    """Return the layers of a part, or of all: channels with one name before the last dot, each channel without a dot.

    The channels without a dot of a part are also together a layer, which has the part's name. Those that are components
    of a vector or colour, such as x, y, z, are no layers each.
    """
    found = []
    for index in parts_to_read(specs, part):
        groups: dict[str, dict[str, str]] = {}
        plain: dict[str, str] = {}
        for channel in specs[index].channelnames:
            before, _, last = channel.rpartition(".")
            if before:
                groups.setdefault(before, {})[last] = channel
            else:
                plain[channel] = channel
        found += [Layer(index, name, channels) for name, channels in groups.items()]
        components = {name for family in _VECTORS if set(family[:2]) <= plain.keys() for name in family}
        found += [Layer(index, channel, {"": channel}) for channel in plain if channel not in components]
        if plain:
            found.append(Layer(index, part_name(specs[index]), plain))
    return found


def find_usual(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], names: Names, pick: Pick) -> Selection | None:
    """Return the channels of the layer with the best usual name; None where no layer has any.

    Raises ReadError (ambiguous-layer) where several layers have that name.
    """
    layers = list(layers)
    for usual in names.usual:
        found = [layer for layer in layers if plain_name(layer.name) == usual and pick(layer)]
        if found:
            return _only(specs, found, names, pick)
    return None


def find_named(
    specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], layer: str, names: Names, pick: Pick
) -> Selection:
    """Return the channels of the layer that is called ``layer``.

    That is a layer's whole name ("ViewLayer.Depth"), a channel's ("ViewLayer.Depth.Z"), the name of a part, or the last
    part of a layer's name ("Depth"). Raises ReadError: no-layer, ambiguous-layer, or wrong-layer, where its channels do
    not fit the pass.
    """
    layers = list(layers)
    channels = [
        Layer(each.part, name, {"": name}) for each in layers for name in each.channels.values() if name == layer
    ]
    found = [each for each in layers if each.name == layer] or channels
    found = found or [each for each in layers if part_name(specs[each.part]) == layer]
    found = found or [each for each in layers if each.name.rpartition(".")[2] == layer]
    if not found:
        known = {each.name for each in layers} | {name for each in layers for name in each.channels.values()}
        known |= {part_name(specs[each.part]) for each in layers} - {""}
        message = f"layer {layer!r} is not in the file; {listing(specs)}"
        raise ReadError(message, code="no-layer", hint=nearest(layer, known), parameter="layer")
    fitting = [each for each in found if pick(each)]
    if not fitting:
        holds = few(list(found[0].channels.values()))
        message = f"layer {layer!r} has the channels {holds}; expected for {names.what}: {names.channels}"
        raise ReadError(message, code="wrong-layer", parameter="layer")
    return _only(specs, fitting, names, pick)


def missing(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], names: Names) -> ReadError:
    """Return the error for a file without a layer of any usual name; it hints at the layer that comes nearest."""
    likeness = {
        layer.name: max(SequenceMatcher(None, plain_name(layer.name), usual).ratio() for usual in names.usual)
        for layer in layers
    }
    best = max(likeness, key=lambda name: likeness[name], default="")
    near = f"layer: {best!r}?" if best and likeness[best] >= 0.6 else "name the layer"
    message = f"no layer with a usual name for {names.what} ({', '.join(names.usual)}); {listing(specs)}"
    return ReadError(message, code="no-layer", hint=near, parameter="layer")


def _only(specs: Sequence[oiio.ImageSpec], found: Sequence[Layer], names: Names, pick: Pick) -> Selection:
    """Return the channels of the only layer; raise ReadError with all names where there are several."""
    distinct: dict[tuple[int, tuple[str, ...]], Layer] = {}
    for layer in found:
        distinct.setdefault((layer.part, pick(layer) or ()), layer)
    (part, channels), first = next(iter(distinct.items()))
    if len(distinct) > 1:
        layers = list(dict.fromkeys(layer.name for layer in distinct.values()))
        parts = [part_name(specs[layer.part]) or str(layer.part) for layer in distinct.values()]
        where = f"layers {few(layers)}" if len(layers) > 1 else f"layer {layers[0]!r} in the parts {few(parts)}"
        choices = [f"layer: {name!r}" for name in layers] if len(layers) > 1 else [f"part: {name!r}" for name in parts]
        raise ReadError(
            f"{names.what} could be read from several places: {where}",
            code="ambiguous-layer",
            hint=few(choices, " or "),
            parameter="layer" if len(layers) > 1 else "part",
        )
    return Selection(part, first.name, channels)
