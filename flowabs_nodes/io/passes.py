"""Find the layers of a render pass by the names that renderers give them, or by the name that somebody asks for.

Pure functions on ImageSpecs. Which names are usual is said once, in :mod:`flowabs_nodes.io.pass_names`. In a stereo
file the default view is chosen, and the selection's note says so.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, likely
from flowabs_nodes.io.layer_groups import Layer, Pick, called, inside_of, names_to_ask, of_default_view, within
from flowabs_nodes.io.layers import Selection, few, listing, part_name
from flowabs_nodes.io.pass_names import Names, plain_name


def find_usual(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], names: Names, pick: Pick) -> Selection | None:
    """Return the channels of the layer with the best usual name; None where no layer has any.

    Raises ReadError (ambiguous-layer) where several layers have that name.
    """
    layers = list(layers)
    for usual in names.usual:
        found = [layer for layer in layers if plain_name(layer.base) == usual and pick(layer)]
        if found:
            return _only(specs, found, names, pick)
    return None


def find_only(layers: Iterable[Layer], pick: Pick) -> Selection | None:
    """Return the channels of the one layer that a file consists of: a pass that has a file of its own; else None.

    Its channels have no layer's name in front: what is called something is what it is called.
    """
    layers = list(layers)
    everything = {(each.part, name) for each in layers for name in each.channels.values()}
    if any("." in name for _, name in everything):
        return None
    for layer in layers:
        channels = pick(layer) if layer.is_one_thing else None
        if channels and everything == {(layer.part, name) for name in layer.channels.values()}:
            said = f"the file's only layer, {', '.join(channels)}, is read"
            return Selection(layer.part, layer.name, channels, said, guessed="".join(layer.channels) or layer.name)
    return None


def find_named(
    specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], layer: str, names: Names, pick: Pick
) -> Selection:
    """Return the channels of the layer that is called ``layer``.

    That is any name that :func:`~flowabs_nodes.io.layer_groups.called` knows, or a channel's ("ViewLayer.Depth.Z"). The
    name of a view layer or view ("Fg", "right", "Fg.right") means the pass with a usual name in it. Raises ReadError:
    unknown-layer, no-layer where that view layer has no such pass, ambiguous-layer, or wrong-layer, where its channels
    do not fit the pass.
    """
    layers = list(layers)
    inside = find_usual(specs, inside_of(specs, layers, layer, pick), names, pick)
    if inside:
        return inside
    channels = [
        Layer(each.part, name, {"": name}, each.view)
        for each in layers
        for name in each.channels.values()
        if name == layer
    ]
    found = [each for each in layers if each.name == layer] or channels or called(specs, layers, layer)
    if not found:
        if there := within(specs, layers, layer):
            raise missing(specs, there, names)
        known = {name for each in layers for name in (*each.names, *each.channels.values())}
        known |= {part_name(specs[each.part]) for each in layers}
        message = f"layer {layer!r} is not in the file; {listing(specs)}"
        raise ReadError(message, code="unknown-layer", hint=likely(layer, known - {""}), parameter="layer")
    fitting = [each for each in found if pick(each)]
    if not fitting:
        holds = few(list(found[0].channels.values()))
        message = f"layer {layer!r} has the channels {holds}; expected for {names.what}: {names.channels}"
        raise ReadError(message, code="wrong-layer", parameter="layer")
    return _only(specs, fitting, names, pick)


def missing(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], names: Names) -> ReadError:
    """Return the error for a file without a layer of any usual name; it hints at the layer that comes nearest."""
    likeness = {
        layer.name: max(SequenceMatcher(None, plain_name(layer.base), usual).ratio() for usual in names.usual)
        for layer in layers
    }
    best = max(likeness, key=lambda name: likeness[name], default="")
    near = f"layer: {best!r}?" if best and likeness[best] >= 0.6 else "name its layer, or the file that has it"
    message = f"no layer with a usual name for {names.what} ({', '.join(names.usual)}); {listing(specs)}"
    return ReadError(message, code="no-layer", hint=near, parameter="layer")


def guessed_wrong(chosen: Selection, names: Names, why: str, meant: bool = True) -> ReadError:
    """Return the error for a file's only layer that is not the pass that it was taken for, and ``why``.

    Where it may be ``meant`` all the same, the hint says how to say so.
    """
    hint = f"layer: {chosen.guessed!r}, if it holds {names.what}" if meant else "file: the file that has the pass"
    message = f"no {names.what} in the file: in its only layer, {', '.join(chosen.channels)}, {why}"
    return ReadError(message, code="no-layer", hint=hint, parameter="layer")


def _only(specs: Sequence[oiio.ImageSpec], found: Sequence[Layer], names: Names, pick: Pick) -> Selection:
    """Return the channels of the only layer, in stereo of the default view; raise ReadError where there are several."""
    found, said = of_default_view(specs, found)
    distinct: dict[tuple[int, tuple[str, ...]], Layer] = {}
    for layer in found:
        distinct.setdefault((layer.part, pick(layer) or ()), layer)
    (part, channels), first = next(iter(distinct.items()))
    if len(distinct) > 1:
        layers = list(dict.fromkeys(layer.name for layer in distinct.values()))
        parts = [part_name(specs[layer.part]) or str(layer.part) for layer in distinct.values()]
        where = f"layers {few(layers)}" if len(layers) > 1 else f"layer {layers[0]!r} in the parts {few(parts)}"
        asked, alone = names_to_ask(specs, list(distinct.values()))
        choices = [f"layer: {name!r}" for name in asked] if len(layers) > 1 else [f"part: {name!r}" for name in parts]
        raise ReadError(
            f"{names.what} could be read from several places: {where}",
            code="ambiguous-layer",
            hint=few(choices, " or ") + alone,
            parameter="layer" if len(layers) > 1 else "part",
        )
    return Selection(part, first.name, channels, said)
