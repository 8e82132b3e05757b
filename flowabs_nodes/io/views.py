"""Know the views of a stereo file: those of one part, by the attribute multiView and the channels' names (OpenEXR).

The first view of multiView is the default: its channels have plain names, R, G, B. Those of another view have its name
before the last dot: "left.R", "diffuse.left.R".
"""

from __future__ import annotations

from collections.abc import Iterable

import OpenImageIO as oiio

from flowabs_nodes.image import Origin


def views_of(spec: oiio.ImageSpec) -> tuple[str, ...]:
    """Return the views that a header names, the default first; () where it names none."""
    value = spec.getattribute("multiView")
    return tuple(str(each) for each in value) if isinstance(value, tuple | list) else ()


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
