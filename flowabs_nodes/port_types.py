"""Declare the types of pictures that nodes exchange: all that the package asks about one is a field here."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.filters.background import FAR

#: The name of a port type, a key of :data:`TYPES`.
PortType = str


@dataclass(frozen=True)
class PixelType:
    """A port type: what its pixels are, and what happens to them between the nodes.

    Attributes
    ----------
    name, label, help
        The name in declarations and messages, the name for people, and one line for the docs.
    channels
        The sets of channel names that a picture may have, in the order of the pixels' last axis; empty: any channels.
        In a layer of a file a channel is called by the last part of its name: the layer's ``n.X`` for ``N.X``.
    dtype
        The data type of the pixels, float32 or uint32.
    widens_to
        The types that a picture may also be used as: its one channel is repeated.
    filtered
        How a picture becomes smaller: by a filter (True), or by taking the nearest pixel (False), for what has no mean
        across an edge.
    blends
        True where ``mask`` and ``mix`` weigh result and input; False where each pixel is one of the two, the result
        from a weight of one half on.
    light
        True where the numbers are light, which may come encoded (sRGB, a log); a matte is none, though it is looked at.
    unit
        True where each pixel is a vector of length 1.
    lengths
        For each channel the axis, "x" or "y", along which it is a length in pixels; empty: no channel is one. Lengths
        grow and shrink with the picture.
    outside
        The value where a picture has no pixels: beyond its data window, and in a frame that is left black.
    stored
        The data type in an EXR. "plate": the plate's, else half, NaN as 0. "float": 32 bit unless half is asked for,
        NaN as 0. "read": half if it was read as half, else float; NaN and Inf stay. "exact": ``dtype`` whatever is
        asked for, every bit as it is.
    usual
        The range in which most values lie, for pictures that show or test the type.
    rgba
        Which of the channels R, G, B, A of a host's picture hold one of the type; "" where none can.
    look
        "module:function", imported when it is first needed, that makes a picture to look at (``--view``, and in
        notebooks); not asked for of color, which goes through the view transform.
    """

    name: str
    label: str
    help: str
    channels: tuple[tuple[str, ...], ...]
    dtype: np.dtype[Any] = np.dtype(np.float32)  # noqa: RUF009 - a dtype is immutable
    widens_to: frozenset[str] = frozenset()
    filtered: bool = False
    blends: bool = True
    light: bool = False
    unit: bool = False
    lengths: tuple[Literal["x", "y"], ...] = ()
    outside: float = 0.0
    stored: Literal["plate", "float", "read", "exact"] = "exact"
    usual: tuple[float, float] = (0.0, 1.0)
    rgba: str = ""
    look: str = "flowabs_nodes.looking.data:look_at_data"

    @property
    def an_image(self) -> str:
        """Return what to call a picture of the type in a sentence: "a depth image", "an id image"."""
        return f"{'an' if self.name[0] in 'aeiou' else 'a'} {self.name} image"

    @property
    def shown(self) -> bool:
        """Return True if the picture is one to look at: colour, or what may be used as colour."""
        return "color" in (self.name, *self.widens_to)

    @property
    def typical_channels(self) -> tuple[str, ...]:
        """Return the channel names that a picture has at least; of a type with any channels, names to try it with."""
        return self.channels[0] if self.channels else ("Z", "id")

    @property
    def bytes_per_pixel(self) -> int:
        """Return about how many bytes a pixel takes in memory."""
        return self.dtype.itemsize * max((len(names) for names in self.channels), default=4)

    def look_function(self) -> Callable[[Any], Any]:
        """Return the function that ``look`` names: of an image it makes a :class:`~flowabs_nodes.looking.look.Look`."""
        module, _, name = self.look.partition(":")
        function: Callable[[Any], Any] = getattr(import_module(module), name)
        return function

    def channel_names(self, count: int) -> tuple[str, ...] | None:
        """Return the names of a picture's ``count`` channels; None where the type does not tell."""
        return next((names for names in self.channels if len(names) == count), None)

    def expected_channels(self, prefix: str = "") -> str:
        """Return the channel names that a picture may have, for error messages: "R,G,B or R,G,B,A"."""
        return " or ".join(",".join(prefix + name for name in names) for names in self.channels) or "any"

    def cast(self, pixels: npt.ArrayLike, *, whole_floats: bool = False) -> npt.NDArray[Any]:
        """Return numbers of any shape in the type's dtype, C-contiguous; the array itself where it is that already.

        Ids must be whole numbers from 0 to 2**32 - 1, floating point only with ``whole_floats``: an id that was
        calculated with is no id. Raises ArgumentError for others.
        """
        array = np.asarray(pixels)
        if self.dtype.kind == "u" and array.dtype != self.dtype:
            low, high = 0, np.iinfo(self.dtype).max
            whole = array.dtype.kind in "iub" or (whole_floats and bool((array == np.floor(array)).all()))
            if not whole or not bool(((array >= low) & (array <= high)).all()):
                raise ArgumentError(
                    f"{self.name} pixels are whole numbers from {low} to {high} ({self.dtype}), "
                    f"found {array.dtype}{'' if whole_floats or not whole else ' outside that range'}",
                    parameter="pixels",
                )
        return np.ascontiguousarray(array, self.dtype)


_DECLARED: dict[str, PixelType] = {
    each.name: each
    for each in (
        PixelType(
            "color",
            label="Colour",
            help="scene-linear, premultiplied; a grey plate is read as color",
            channels=(("R", "G", "B"), ("R", "G", "B", "A")),
            filtered=True,
            light=True,
            stored="plate",
            rgba="RGBA",
        ),
        PixelType(
            "mono",
            label="Mono",
            help="any scalar picture: a response, a LIC",
            channels=(("Y",),),
            widens_to=frozenset({"color"}),
            filtered=True,
            light=True,
            stored="plate",
            usual=(-10.0, 30.0),
            rgba="R",
            look="flowabs_nodes.looking.grey:look_at_grey",
        ),
        PixelType(
            "matte",
            label="Matte",
            help="0 to 1: lines, masks",
            channels=(("Y",),),
            widens_to=frozenset({"mono", "color"}),
            filtered=True,
            stored="plate",
            rgba="A",
            look="flowabs_nodes.looking.grey:look_at_grey",
        ),
        PixelType(
            "flow",
            label="Flow",
            help="unit tangents, x to the right, y down; sign has no meaning",
            channels=(("flow.x", "flow.y"),),
            unit=True,
            stored="float",
            look="flowabs_nodes.looking.flow:look_at_flow",
        ),
        PixelType(
            "depth",
            label="Depth",
            help="distance from the camera in scene units; 1e10 is the background",
            channels=(("Z",),),
            outside=FAR,
            usual=(1.0, 50.0),
            rgba="R",
            look="flowabs_nodes.looking.depth:look_at_depth",
        ),
        PixelType(
            "normal",
            label="Normal",
            help="unit normals, in the renderer's space",
            channels=(("N.X", "N.Y", "N.Z"),),
            unit=True,
            rgba="RGB",
            look="flowabs_nodes.looking.normal:look_at_normal",
        ),
        PixelType(
            "motion",
            label="Motion",
            help="pixels, y up, as Blender has it: X, Y to the place on the previous frame, -Z, -W to that on the next",
            channels=(("motion.X", "motion.Y", "motion.Z", "motion.W"),),
            lengths=("x", "y", "x", "y"),
            usual=(-8.0, 8.0),
            rgba="RGBA",
            look="flowabs_nodes.looking.motion:look_at_motion",
        ),
        PixelType(
            "id",
            label="Id",
            help="whole numbers from 0 to 4294967295, exact; 0 is the background",
            channels=(("id",),),
            dtype=np.dtype(np.uint32),
            blends=False,
            usual=(0.0, 4294967296.0),
            rgba="R",
            look="flowabs_nodes.looking.ids:look_at_ids",
        ),
        PixelType(
            "data",
            label="Data",
            help="other AOVs, any channels: never colour-converted, never clamped",
            channels=(),
            stored="read",
            usual=(0.0, 100.0),
        ),
    )
}

#: Every port type by its name. A type that is added to the declarations above needs nothing else.
TYPES: Mapping[str, PixelType] = MappingProxyType(_DECLARED)
#: The names of all port types.
PORT_TYPES: Collection[str] = TYPES.keys()


def pixel_type(name: str) -> PixelType:
    """Return the declaration of a port type; ArgumentError, with the nearest name, where there is none."""
    if name not in TYPES:
        raise ArgumentError(f"{name!r} is not a port type", hint=nearest(name, PORT_TYPES), parameter="type")
    return TYPES[name]


def widest(names: Iterable[str]) -> str | None:
    """Return the port type among these that each of the others may be used as; None where there is none."""
    names = tuple(names)
    return next((one for one in names if all(name == one or one in TYPES[name].widens_to for name in names)), None)
