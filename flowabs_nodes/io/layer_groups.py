"""Group a file's channels to layers, and find layers by what somebody calls them: pure functions on ImageSpecs.

A renderer writes many layers into one file, sorted by up to three things: the view layer (Blender's word for a set of
objects that is rendered by itself), the pass and, in stereo, the view, left or right. Blender 4.5 writes one part with
channels such as "ViewLayer.Depth.left.Z"; Blender 5 a part for each pass and view, "ViewLayer.Depth-left", that has the
attribute ``view`` and the channel "ViewLayer.Depth.Z". The name of a view layer may have dots: the last one counts.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import OpenImageIO as oiio

from flowabs_nodes.io.layers import few, part_name, parts_to_read
from flowabs_nodes.io.oiio_error import printable
from flowabs_nodes.io.pass_names import same_pass
from flowabs_nodes.io.views import part_view, split_view, views_in

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
    """Channels of one part that belong together; ``channels`` maps the last part of each name to the whole name.

    ``name`` is what stands before the last dot of its channels, ``view`` the view that it belongs to, "" where the file
    has none, and ``base`` the name without the view: "ViewLayer.Depth" of "ViewLayer.Depth.left".
    """

    part: int
    name: str
    channels: dict[str, str]
    view: str = ""
    base: str = ""

    @property
    def view_layer(self) -> str:
        """What stands before the name of the pass: "Bg.01" of "Bg.01.Depth"."""
        return self.base.rpartition(".")[0]

    @property
    def names(self) -> set[str]:
        """What it may be asked for by: its name, without the view, its last part; and its view layer's."""
        return {self.name, self.base, self.base.rpartition(".")[2], self.view_layer} - {""}

    @property
    def is_one_thing(self) -> bool:
        """Whether its channels are one number, or components of one vector or colour."""
        return len(self.channels) == 1 or any(self.channels.keys() <= set(family) for family in _VECTORS)

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


def layers_of(specs: Sequence[oiio.ImageSpec], part: str | int = "") -> list[Layer]:
    """Return the layers of a part, or of all: channels with one name before the last dot, each channel without a dot.

    The channels without a dot of a part are also together a layer, which has the part's name. Those that are components
    of a vector or colour, such as x, y, z, are no layers each. What has only the name of a view before it, "right.Z",
    counts as without a dot too.
    """
    views = views_in(specs)
    found = []
    for index in parts_to_read(specs, part):
        own = part_view(specs[index])
        groups: dict[str, dict[str, str]] = {}
        for channel in specs[index].channelnames:
            before, _, last = channel.rpartition(".")
            groups.setdefault(before, {})[last] = channel
        plain = groups.pop("", {})
        for name, channels in groups.items():
            base, view = split_view(name, views)
            found.append(Layer(index, name, channels, view or own, base))
            if not base:
                found += _single_layers(index, channels, view)
        if plain:
            view = own or (views[0] if views else "")
            found += _single_layers(index, plain, view)
            found.append(Layer(index, part_name(specs[index]), plain, view, part_name(specs[index])))
    return found


def _single_layers(part: int, channels: dict[str, str], view: str) -> list[Layer]:
    """Return a layer for each channel that is no component of a vector or colour."""
    components = {name for family in _VECTORS if set(family[:2]) <= channels.keys() for name in family}
    return [
        Layer(part, channel, {"": channel}, view, name) for name, channel in channels.items() if name not in components
    ]


def called(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], asked: str) -> list[Layer]:
    """Return the layers that ``asked`` is a name of, by the first kind of name that any layer has.

    These are: the layer's whole name, the part's, either with a view behind it ("ViewLayer.Depth.right", also where the
    view is the part's), the pass ("Depth", "Depth.right"), the pass plainly, old names of Blender's included, and of
    channels without a layer their letters ("RGB").
    """
    layers = list(layers)
    views = views_in(specs)
    base, view = split_view(asked, views)
    of_view = [each for each in layers if not view or _is_of(each, view, views)]
    return (
        [each for each in layers if each.name == asked]
        or [each for each in layers if part_name(specs[each.part]) == asked]
        or [each for each in of_view if base and each.base == base]
        or [each for each in of_view if base and each.base.rpartition(".")[2] == base]
        or [each for each in of_view if base and same_pass(each.base, base)]
        or [each for each in layers if not each.name and "".join(each.channels) == asked]
    )


def within(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], asked: str) -> list[Layer]:
    """Return the layers of the view layer or view that is called ``asked``, or of both: "Fg", "right", "Fg.right"."""
    views = views_in(specs)
    base, view = split_view(asked, views)
    if not (view or base):
        return []
    of_view = [each for each in layers if not view or _is_of(each, view, views)]
    return [each for each in of_view if not base or each.view_layer == base]


def inside_of(specs: Sequence[oiio.ImageSpec], layers: Iterable[Layer], asked: str, pick: Pick) -> list[Layer]:
    """Return :func:`within`, but nothing where a layer that ``pick`` takes has the very name, and no view has it."""
    layers = list(layers)
    exact = any(each.name == asked and pick(each) for each in layers)
    return [] if exact and asked not in views_in(specs) else within(specs, layers, asked)


def of_default_view(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer]) -> tuple[list[Layer], str]:
    """Return the layers without those of other views than the first that any is of; and what to say about that."""
    views = views_in(specs)
    there = [view for view in views if any(_is_of(each, view, views) for each in layers)]
    if len(there) < 2:
        return list(layers), ""
    said = f"view {printable(there[0])!r} is read, one of {len(views)}: {few(views)}; `layer` says which"
    return [each for each in layers if _is_of(each, there[0], views)], said


def _is_of(layer: Layer, view: str, views: tuple[str, ...]) -> bool:
    """Return whether a layer is of a view; what names none, "Depth.Z" beside "Depth.left.Z", is of the default one."""
    return (layer.view or views[0]) == view


def names_to_ask(specs: Sequence[oiio.ImageSpec], layers: Sequence[Layer]) -> tuple[list[str], str]:
    """Return the names by which several layers can be asked for, and, for a hint, that a view layer's is enough.

    The second is "" where view layers do not tell them apart.
    """
    views = views_in(specs)
    suffixes = ["" if each.view in ("", *views[:1]) else f".{each.view}" for each in layers]
    pairs = list(zip(layers, suffixes, strict=True))
    names = list(dict.fromkeys(each.base + suffix if suffix else each.name for each, suffix in pairs))
    alone = list(dict.fromkeys(each.view_layer + suffix for each, suffix in pairs if each.view_layer))
    if len(alone) < len(layers):
        return names, ""
    return names, f"; the view layer alone, {printable(alone[-1])!r}, does in every node that reads the file"
