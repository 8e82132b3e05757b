"""Know the views of a stereo file, by its attributes and the channels' names (OpenEXR).

In one part the attribute multiView names them. The first is the default: its channels have plain names, R, G, B. Those
of another view have its name before the last dot: "left.R", "diffuse.left.R". Blender 4.5 gives it to the default view
too: "ViewLayer.Depth.left.Z". Of several parts, each has the attribute view.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import OpenImageIO as oiio

from flowabs_nodes.image import Origin


def views_of(spec: oiio.ImageSpec) -> tuple[str, ...]:
    """Return the views that a header names, the default first; () where it names none."""
    value = spec.getattribute("multiView")
    return tuple(str(each) for each in value) if isinstance(value, tuple | list) else ()


def part_view(spec: oiio.ImageSpec) -> str:
    """Return the view that a whole part belongs to; "" where its header names none."""
    return str(spec.get_string_attribute("view"))


def views_in(specs: Sequence[oiio.ImageSpec]) -> tuple[str, ...]:
    """Return the views of a file, the default first; () where it has none.

    They are those of multiView, else those that the parts name, else left and right where layers of both are there.
    """
    for spec in specs:
        if views := views_of(spec):
            return views
    named = tuple(dict.fromkeys(view for spec in specs if (view := part_view(spec))))
    if len(named) > 1:
        return named
    layers = {channel.rpartition(".")[0] for spec in specs for channel in spec.channelnames}
    both = any(split_view(layer, ("left",))[1] and layer[: -len("left")] + "right" in layers for layer in layers)
    return ("left", "right") if both else ()


def split_view(layer: str, views: tuple[str, ...]) -> tuple[str, str]:
    """Return a layer's name without its view, and the view: ("Fg.Depth", "left") of "Fg.Depth.left", ("", "left")."""
    before, _, last = layer.rpartition(".")
    return (before, last) if last in views else (layer, "")


def view_of(channel: str, views: tuple[str, ...]) -> str:
    """Return the view of a channel; "" for a channel of a layer, such as "diffuse.R", which names none."""
    words = channel.split(".")
    if len(words) == 1:
        return views[0] if views else ""
    return words[-2] if words[-2] in views else ""


def read_view(origin: Origin, views: tuple[str, ...]) -> str:
    """Return the view that was read of a stereo part; the default one where the layer that was read names none."""
    view = view_of(origin.channels[0], views) if origin.channels else ""
    return view or (views[0] if views else "")


def renamed(channel: str, views: tuple[str, ...], default: str) -> str:
    """Return a channel's name where ``default`` is the default view: "right.R" for "R", and "R" for "left.R"."""
    view = view_of(channel, views)
    if not view or not views or default == views[0]:
        return channel
    *before, last = channel.split(".")
    bare = before[:-1] if before and before[-1] == view else before
    return ".".join([*bare, last] if view == default else [*bare, view, last])


def views_there(channels: Iterable[str], views: tuple[str, ...], default: str) -> tuple[str, ...]:
    """Return the views that have a channel among these, ``default`` first."""
    there = {view_of(channel, (default, *views)) for channel in channels}
    return (default, *(view for view in views if view in there and view != default))
