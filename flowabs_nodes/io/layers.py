"""Find the part and the channels of a file that a layer's name means: pure functions on ImageSpecs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.errors import ReadError, nearest
from flowabs_nodes.io.oiio_error import printable
from flowabs_nodes.io.picture_names import is_other, is_picture, rank
from flowabs_nodes.io.views import views_of

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


class Selection(NamedTuple):
    """Channels to read from one part, in order: red, green, blue or one grey, then alpha if the layer has it.

    ``note`` is for the log: why these channels, where nobody asked for them.
    """

    part: int
    layer: str
    channels: tuple[str, ...]
    note: str = ""

    @property
    def grey(self) -> bool:
        """True where one channel stands for red, green and blue alike."""
        return len(self.channels) < 3

    @property
    def has_alpha(self) -> bool:
        """True where the last channel is alpha."""
        return len(self.channels) in (2, 4)


def layer_of(channel: str) -> str:
    """Return the layer of a channel: "diffuse" of "diffuse.R", "Z" of "Z", and "", the main layer, of R, G, B, A."""
    before, dot, _ = channel.rpartition(".")
    if dot:
        return before
    return "" if channel in ("R", "G", "B", "A") else channel


def part_name(spec: oiio.ImageSpec) -> str:
    """Return the name of a part; empty where it has none."""
    return spec.get_string_attribute("oiio:subimagename") or spec.get_string_attribute("name")


def choose_color(specs: Sequence[oiio.ImageSpec], layer: str = "", part: str | int = "") -> Selection:
    """Choose the channels of a color image: R, G, B or grey, and A.

    ``layer`` and ``part`` are as in :func:`flowabs_nodes.io.read.read_image`. Raises ReadError, which lists what the
    file holds, where there is no such layer or part, or no colour in it.
    """
    candidates = parts_to_read(specs, part)
    if layer == "":
        return _plain(specs, candidates) or _only_layer(specs, candidates, part)
    for index in candidates:
        found = _pick(specs[index].channelnames, layer + ".", (*_RGBA, *_GREY))
        if found:
            return Selection(index, layer, found)
    for index in candidates:
        if part_name(specs[index]) == layer:
            found = _pick(specs[index].channelnames, "", (*_RGBA, *_GREY))
            if found:
                return Selection(index, layer, found)
    layers = _color_layers(specs, candidates)
    everything = {layer_of(name) for index in candidates for name in specs[index].channelnames}
    what = "has no red, green and blue (nor Y)" if layer in everything else "is not in the file"
    hint = nearest(layer, [name or '""' for name in layers]) if layers else ""
    raise ReadError(f"layer {layer!r} {what}; {listing(specs)}", code="no-layer", hint=hint, parameter="layer")


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
    known = {
        name for index in candidates for channel in specs[index].channelnames for name in (channel, layer_of(channel))
    }
    known |= {part_name(specs[index]) for index in candidates}
    message = f"layer {layer!r} is not in the file; {listing(specs)}"
    raise ReadError(message, code="no-layer", hint=nearest(layer, known - {""}), parameter="layer")


def parts_to_read(specs: Sequence[oiio.ImageSpec], part: str | int) -> list[int]:
    """Return the parts to look in: one by its index or name, or all that are not deep. Raises ReadError for none."""
    text = str(part)
    if text:
        named = [index for index, spec in enumerate(specs) if part_name(spec) == text]
        index = named[0] if named else int(text) if text.isdecimal() else len(specs)
        if index >= len(specs):
            names = [part_name(spec) or str(index) for index, spec in enumerate(specs)]
            message = f"part {part!r} is not in the file; it has {len(specs)}: {few(names)}"
            raise ReadError(message, code="no-part", hint=nearest(text, names), parameter="part")
        if specs[index].deep:
            raise ReadError(f"part {part!r} is deep data, which is not read", code="deep", parameter="part")
        return [index]
    flat = [index for index, spec in enumerate(specs) if not spec.deep]
    if not flat:
        raise ReadError("deep data, which is not read; flatten it first", code="deep")
    return flat


def _pick(channels: Sequence[str], prefix: str, families: Iterable[tuple[str, ...]]) -> tuple[str, ...] | None:
    """Return the channels of the first family that is there, its alpha included where there is one; else None.

    A family is the names of its colours, then that of its alpha.
    """
    for *wanted, alpha in families:
        found = [prefix + name for name in wanted]
        if len(wanted) == 1 and any(prefix + name in channels for name in _NO_GREY):
            continue
        if set(found) <= set(channels):
            return (*found, prefix + alpha) if prefix + alpha in channels else tuple(found)
    return None


def _plain(specs: Sequence[oiio.ImageSpec], parts: Sequence[int]) -> Selection | None:
    """Return plain R, G, B, else plain Y, of the part whose name is most like a picture's; None where there is none."""
    for names in (_RGBA, _GREY):
        found = [Selection(i, "", pick) for i in parts if (pick := _pick(specs[i].channelnames, "", names))]
        if not found:
            continue
        best = min(found, key=lambda each: rank(part_name(specs[each.part])))
        if is_other(part_name(specs[best.part])) and any(map(is_picture, _color_layers(specs, parts))):
            return None
        return best._replace(note=_which(specs, best, found))
    return None


def _which(specs: Sequence[oiio.ImageSpec], chosen: Selection, found: Sequence[Selection]) -> str:
    """Return for the log which of several parts or views is read; "" where there is no other."""
    if len(found) > 1:
        names = [part_name(specs[each.part]) or str(each.part) for each in found]
        mine = names[found.index(chosen)]
        return f"part {printable(mine)!r} is read, one of {len(found)} with colour: {few(names)}; `part` says which"
    views = views_of(specs[chosen.part])
    if len(views) > 1 and any(layer in views for layer in _color_layers(specs, [chosen.part])):
        return f"view {printable(views[0])!r} is read, one of {len(views)}: {few(views)}; `layer` says which"
    return ""


def _color_layers(specs: Sequence[oiio.ImageSpec], parts: Sequence[int]) -> dict[str, Selection]:
    """Return every layer with red, green and blue, by name."""
    layers: dict[str, Selection] = {}
    for index in parts:
        for layer in dict.fromkeys(name.rpartition(".")[0] for name in specs[index].channelnames):
            found = _pick(specs[index].channelnames, layer and layer + ".", _RGBA)
            if found:
                layers.setdefault(layer, Selection(index, layer, found))
    return layers


def _only_layer(specs: Sequence[oiio.ImageSpec], parts: Sequence[int], part: str | int) -> Selection:
    """Choose a layer of a file without plain R, G, B: the one that is named as a picture, or the only one with colour.

    Of a stereo file the default view is chosen. Raises ReadError where there is no colour, or a choice that nobody but
    the user can make, as between two of Blender's view layers.
    """
    layers = _color_layers(specs, parts)
    names = _of_default_view(specs, parts, list(layers))
    best = min((rank(name) for name in names), default=None)
    named = [name for name in names if is_picture(name) and rank(name) == best]
    single = named or names
    if len(single) == 1:
        chosen = layers[single[0]]
        of = f", one of {len(layers)} with colour: {few(list(layers))}; `layer` says which" if len(layers) > 1 else ""
        return chosen._replace(note=f"no plain R, G, B: layer {chosen.layer!r} is read{of}")
    hint = ""
    if layers:
        hint = "layer: " + few([repr(name) for name in layers], " or ")
    raise ReadError(f"no R, G, B and no Y to read as colour; {listing(specs)}", code="no-color", hint=hint)


def _of_default_view(specs: Sequence[oiio.ImageSpec], parts: Sequence[int], layers: list[str]) -> list[str]:
    """Return the layers without those of other views than the first, "Combined.right" beside "Combined.left"."""
    views = next((views for index in parts if (views := views_of(specs[index]))), ("left", "right"))
    kept = []
    for name in layers:
        before, dot, last = name.rpartition(".")
        first = f"{before}{dot}{views[0]}"
        if last not in views[1:] or first not in layers:
            kept.append(name)
    return kept


def check_windows(specs: Sequence[oiio.ImageSpec], chosen: Sequence[Selection]) -> None:
    """Raise ReadError unless all chosen layers, which may be in several parts, are on one data window."""
    windows = {(spec.x, spec.y, spec.width, spec.height) for spec in (specs[each.part] for each in chosen)}
    if len(windows) > 1:
        names = few([each.layer for each in chosen])
        raise ReadError(f"layers {names} belong together, but have different data windows", code="window-mismatch")


def listing(specs: Sequence[oiio.ImageSpec]) -> str:
    """Return what a file holds, for messages: "it has R, G, B"."""
    if len(specs) == 1:
        return f"it has {few(specs[0].channelnames)}"
    parts = [f"{part_name(spec) or index} ({few(spec.channelnames)})" for index, spec in enumerate(specs)]
    return f"it has the parts {few(parts)}"


def few(names: Sequence[str], joint: str = ", ") -> str:
    """Return at most twelve names as a list for messages, each cut at 100 characters."""
    shown = [printable(name if len(name) < 100 else name[:97] + "...") for name in names[:12]]
    return joint.join(shown) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
