"""Choose the part and the channels that a plate, or data, is read from: pure functions on ImageSpecs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, likely
from flowabs_nodes.io.layer_groups import Layer, called, layers_of, names_to_ask, of_default_view, within
from flowabs_nodes.io.layers import Selection, few, layer_of, listing, part_name, parts_to_read
from flowabs_nodes.io.oiio_error import printable
from flowabs_nodes.io.pass_names import ALBEDO, plain_name
from flowabs_nodes.io.picture_names import is_other, is_picture, rank
from flowabs_nodes.io.views import split_view, views_in, views_of

#: Names that files use for red, green, blue, alpha.
_RGBA = (
    ("R", "G", "B", "A"),
    ("r", "g", "b", "a"),
    ("red", "green", "blue", "alpha"),
    ("Red", "Green", "Blue", "Alpha"),
)
_GREY = (("Y", "A"), ("y", "a"))
#: Beside one of these channels a Y is no grey: it is a coordinate, or luminance without its chroma.
_NO_GREY = {"X", "x", "RY", "BY"}


def choose_color(specs: Sequence[oiio.ImageSpec], layer: str = "", part: str | int = "") -> Selection:
    """Choose the channels of a color image: R, G, B or grey, and A.

    ``layer`` and ``part`` are as in :func:`flowabs_nodes.io.read.read_image`. Raises ReadError, which lists what the
    file holds, where there is no such layer or part, no colour in it, or several layers could be meant.
    """
    layers = layers_of(specs, part)
    if layer == "":
        return _plain(specs, parts_to_read(specs, part), layers) or _picture(specs, _colored(layers, _RGBA))
    return _named(specs, layers, layer) or _within(specs, layers, layer) or _refused(specs, layers, layer)


def choose_data(specs: Sequence[oiio.ImageSpec], layer: str = "", part: str | int = "") -> Selection:
    """Choose the channels of a data image: every channel of a layer, one channel by its name, or a whole part.

    Raises ReadError as :func:`choose_color`.
    """
    candidates = parts_to_read(specs, part)
    for index in candidates:
        names = tuple(specs[index].channelnames)
        inside = tuple(name for name in names if name.startswith(layer + "."))
        found = names if layer == "" else inside or tuple(name for name in names if name == layer)
        if found:
            return Selection(index, layer, found)
    for index in candidates:
        if part_name(specs[index]) == layer:
            return Selection(index, layer, tuple(specs[index].channelnames))
    layers = layers_of(specs, part)
    fitting, said = of_default_view(specs, called(specs, layers, layer))
    if len(fitting) == 1:
        return Selection(fitting[0].part, fitting[0].name, tuple(fitting[0].channels.values()), said)
    if fitting:
        raise _ambiguous(specs, fitting)
    known = {
        name for index in candidates for channel in specs[index].channelnames for name in (channel, layer_of(channel))
    }
    known |= {part_name(specs[index]) for index in candidates}
    message = f"layer {layer!r} is not in the file; {listing(specs)}"
    raise ReadError(message, code="unknown-layer", hint=likely(layer, known - {""}), parameter="layer")


# ---------------------------------------------------------------------- nobody asks for a layer


def _plain(specs: Sequence[oiio.ImageSpec], parts: Sequence[int], layers: Sequence[Layer]) -> Selection | None:
    """Return plain R, G, B, else plain Y, of the part whose name is most like a picture's; None where there is none."""
    for names in (_RGBA, _GREY):
        found = [
            Selection(index, "", picked)
            for index in parts
            if (picked := _pick({name: name for name in specs[index].channelnames}, names))
        ]
        if not found:
            continue
        best = min(found, key=lambda each: rank(part_name(specs[each.part])))
        if is_other(part_name(specs[best.part])) and any(is_picture(each.name) for each in _colored(layers, _RGBA)):
            return None
        return best._replace(note=_which(specs, best, found, layers))
    return None


def _which(
    specs: Sequence[oiio.ImageSpec], chosen: Selection, found: Sequence[Selection], layers: Iterable[Layer]
) -> str:
    """Return for the log which of several parts or views is read; "" where there is no other."""
    if len(found) > 1:
        names = [part_name(specs[each.part]) or str(each.part) for each in found]
        mine = names[found.index(chosen)]
        return f"part {printable(mine)!r} is read, one of {len(found)} with colour: {few(names)}; `part` says which"
    views = views_of(specs[chosen.part])
    own = [each for each in layers if each.part == chosen.part and each.name in views]
    if len(views) > 1 and _colored(own, _RGBA):
        return f"view {printable(views[0])!r} is read, one of {len(views)}: {few(views)}; `layer` says which"
    return ""


def _picture(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer], asked: str = "") -> Selection:
    """Choose among layers with colour, of which none is plain: the one that is named as a picture, or the only one.

    Of a stereo file the default view is chosen; a render before the composite that Blender made of it, whose passes
    would not fit. Raises ReadError where there is none, or a choice that nobody but the user can make, as between two
    of Blender's view layers.
    """
    here, said = of_default_view(specs, layers)
    best = min((rank(each.base) for each in here), default=None)
    single = [each for each in here if is_picture(each.base) and rank(each.base) == best] or here
    if len(single) == 1:
        names = list(dict.fromkeys(each.name for each in layers))
        of = f", one of {len(names)} with colour: {few(names)}; `layer` says which" if len(names) > 1 else ""
        note = said if asked else f"no plain R, G, B: layer {printable(single[0].name)!r} is read{of}"
        return _selection(single[0], _RGBA, note if not said or asked else f"{note}; {said}")
    if here:
        named = [each for each in here if is_picture(each.base) and best and rank(each.base)[0] == best[0]]
        raise _ambiguous(specs, named or here)
    raise ReadError(f"no R, G, B and no Y to read as colour; {listing(specs)}", code="no-color")


# ---------------------------------------------------------------------- a layer by its name


def _named(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer], asked: str) -> Selection | None:
    """Return the layer with colour or grey that is called so, of a stereo file in the default view; None for none."""
    families = (*_RGBA, *_GREY)
    found = _colored(called(specs, layers, asked), families)
    found = found or _albedo(specs, layers, asked)
    found, said = of_default_view(specs, found)
    if len({each.name for each in found}) > 1:
        raise _ambiguous(specs, found)
    return _selection(found[0], families, said) if found else None


def _albedo(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer], asked: str) -> list[Layer]:
    """Return the layers with the best usual name of an albedo if ``asked`` is "albedo", "Fg.albedo", "albedo.right"."""
    base, view = split_view(asked, views_in(specs))
    if plain_name(base) != ALBEDO.usual[0]:
        return []
    before, dot, _ = base.rpartition(".")
    names = [before + dot + usual + (f".{view}" if view else "") for usual in ALBEDO.usual]
    return next((found for name in names if (found := _colored(called(specs, layers, name), _RGBA))), [])


def _within(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer], asked: str) -> Selection | None:
    """Return the picture of a view layer or view; None where ``asked`` names none with colour."""
    found = _colored(within(specs, layers, asked), _RGBA)
    return _picture(specs, found, asked) if found else None


def _refused(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer], asked: str) -> Selection:
    """Raise ReadError: the layer is not there, or has no colour."""
    colored = _colored(layers, _RGBA)
    names = {name for each in colored for name in each.names}
    there = bool(called(specs, layers, asked))
    what = "has no red, green and blue (nor Y)" if there else "is not in the file"
    code = "no-layer" if there else "unknown-layer"
    raise ReadError(
        f"layer {asked!r} {what}; {listing(specs)}", code=code, hint=likely(asked, names), parameter="layer"
    )


def _ambiguous(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer]) -> ReadError:
    """Return the error for several layers that could be meant; it says how to name each."""
    names, alone = names_to_ask(specs, layers)
    hint = "layer: " + few([repr(name) for name in names], " or ") + alone
    return ReadError(
        f"several layers could be meant: {few(names)}", code="ambiguous-layer", hint=hint, parameter="layer"
    )


def _colored(layers: Iterable[Layer], families: Iterable[tuple[str, ...]]) -> list[Layer]:
    """Return the layers that have the channels of a family."""
    families = tuple(families)
    return [each for each in layers if _pick(each.channels, families)]


def _selection(layer: Layer, families: Iterable[tuple[str, ...]], note: str) -> Selection:
    """Return the channels of a layer that :func:`_colored` gave."""
    return Selection(layer.part, layer.name, _pick(layer.channels, families) or (), note)


def _pick(channels: dict[str, str], families: Iterable[tuple[str, ...]]) -> tuple[str, ...] | None:
    """Return the channels of the first family that is there, its alpha included where there is one; else None.

    A family is the names of its colours, then that of its alpha; ``channels`` gives the whole name of each.
    """
    for *wanted, alpha in families:
        if len(wanted) == 1 and _NO_GREY & channels.keys():
            continue
        if set(wanted) <= channels.keys():
            names = [*wanted, alpha] if alpha in channels else wanted
            return tuple(channels[name] for name in names)
    return None
