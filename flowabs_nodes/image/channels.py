"""Find the channels of a host's picture in an image's, and an image's in a host's: by name, in any order."""

from __future__ import annotations

from typing import NamedTuple

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.port_types import TYPES, PixelType, PortType, pixel_type

#: A channel of a host's picture that means nothing, as in Qt's RGB32: left out when read, 1 when written.
UNUSED = "X"

#: The names of channels, or those of one letter in one text: ("B", "G", "R", "A") or "BGRA".
Channels = str | tuple[str, ...]


class Layout(NamedTuple):
    """How the channels of an array become those of an image."""

    type: PortType
    names: tuple[str, ...]
    order: tuple[int, ...]  # for each channel of the image the array's


def layout(count: int, type: PortType | None, channels: Channels | None) -> Layout:
    """Return the type and channels of an image of an array with ``count`` channels.

    Without ``type`` and ``channels``, ``count`` decides: one is mono, two are flow, three or four color, more are data.
    ``channels`` are the array's: the names of ``type`` in any order, R, G, B[, A] in any order for color, others for
    data. ArgumentError for channels that do not fit.
    """
    given = None if channels is None else _names(channels)
    if given is not None and len(given) != count:
        raise ArgumentError(
            f"channels: expected {count} names for {count} channels, found {','.join(given)}", parameter="channels"
        )
    used = None if given is None else [name for name in given if name != UNUSED or not isinstance(channels, str)]
    if type is None:
        guess = {1: "mono", 2: "flow", 3: "color", 4: "color"}.get(count, "data")
        if used is not None and _permuted(TYPES["color"], used) is not None:
            guess = "color"
        elif given is not None and given not in TYPES[guess].channels:
            guess = "data"
        type = guess
    declared = pixel_type(type)
    if given is None or used is None:
        names = declared.channel_names(count) or tuple(f"channel{i}" for i in range(count))
        return Layout(type, names, tuple(range(count)))
    names = _permuted(declared, used) or tuple(used)
    return Layout(type, names, tuple(given.index(name) for name in names))


def picks(image: PixelType, names: tuple[str, ...], channels: Channels | None) -> tuple[int | None, ...]:
    """Return for each of ``channels`` its index among ``names``, those of an image; None for one that is 1 everywhere.

    Of a picture to look at (color, mono, matte) R, G, B, A and X can be asked for: a mono's R, G and B are its one
    channel, and A is 1 where an image has none. ``channels`` None are ``names``. ArgumentError for other channels.
    """
    if channels is None or channels == names:
        return tuple(range(len(names)))
    wanted = (channels,) if channels in names else _names(channels)
    places: dict[str, int | None] = {name: index for index, name in enumerate(names)}
    if image.shown:
        grey: dict[str, int | None] = dict.fromkeys("RGB", 0) if len(names) == 1 else {}
        places = {"A": None, UNUSED: None} | grey | places
    unknown = next((name for name in wanted if name not in places), None)
    if unknown is not None or not wanted:
        raise ArgumentError(
            f"channels: {image.an_image} of {','.join(names)} has no {unknown!r}",
            hint=nearest(unknown, places),
            parameter="channels",
        )
    return tuple(places[name] for name in wanted)


def _names(channels: Channels) -> tuple[str, ...]:
    """Return names of channels as a tuple; the letters of a text. Raises ArgumentError for anything else."""
    names = tuple(channels) if isinstance(channels, str | tuple | list) else ()
    if not names or not all(isinstance(name, str) and name for name in names):
        raise ArgumentError(
            f'channels: expected names such as "BGRA" or ("R", "G", "B"), found {channels!r}',
            code="wrong-type",
            parameter="channels",
        )
    return names


def _permuted(declared: PixelType, names: list[str]) -> tuple[str, ...] | None:
    """Return the names of a type's channels in its own order, if ``names`` are just these; else None."""
    return next((own for own in declared.channels if sorted(own) == sorted(names)), None)
