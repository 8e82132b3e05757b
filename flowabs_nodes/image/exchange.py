"""Make images of what hosts hold, and fill what hosts hold with images: arrays, flat buffers, ImageBufs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self, TypeVar, overload

import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import arrays, convert
from flowabs_nodes.image.arrays import Memory, Said, Shown
from flowabs_nodes.image.channels import Channels
from flowabs_nodes.port_types import PortType

Out = TypeVar("Out")


class Exchange:
    """The methods of :class:`~flowabs_nodes.image.Image` that take pictures from hosts and give them back."""

    __slots__ = ()

    if TYPE_CHECKING:  # what an Image has
        type: PortType
        colorspace: ColorSpace

        def __init__(
            self, pixels: Array, spec: oiio.ImageSpec, type: PortType, *, colorspace: ColorSpace | str = ...
        ) -> None: ...
        @property
        def pixels(self) -> Array: ...
        @property
        def spec(self) -> oiio.ImageSpec: ...

    @classmethod
    def from_array(
        cls,
        array: npt.ArrayLike,
        colorspace: ColorSpace | str | None = None,
        *,
        encoding: str | None = None,
        alpha: str | None = None,
        rows: str = "top-down",
        type: PortType | None = None,
        channels: Channels | None = None,
        shape: Sequence[int] | None = None,
        row_bytes: int | None = None,
        dtype: npt.DTypeLike | None = None,
        data_window: Sequence[int] | None = None,
        display_window: Sequence[int] | None = None,
    ) -> Self:
        """Return an image of (H, W) or (H, W, C) numbers, which are copied, once.

        One channel is mono, two are flow, three or four color, unless ``type`` says else. Color is scene-linear RGB or
        premultiplied RGBA unless ``colorspace``, ``encoding`` and ``alpha`` say else; these say nothing of types that
        are no colour. ``data`` takes any channels, with any names; ids are whole numbers. NaN and Inf stay.

        Parameters
        ----------
        array
            An array, or whatever NumPy reads as one; with ``shape`` a flat buffer: a 1-D array, bytes, ctypes ...
        colorspace
            The scene-linear space of the numbers and of the image; None is linear Rec.709. It may also name an
            encoding, as :func:`~flowabs_nodes.io.read.read_image` takes it: "sRGB", a camera's log. Color and mono are
            then decoded to the scene-linear space with its primaries (sRGB to linear Rec.709, ACEScct to AP1).
        encoding
            What the numbers are, by the name of any colour space, where ``colorspace`` is to be the image's alone:
            they are decoded, and converted to ``colorspace`` if that is given. "linear": scene-linear in
            ``colorspace``. With it or an encoding as ``colorspace``, uint8 and uint16 are divided by 255 or 65535, of
            a matte too with this argument.
        alpha
            "premultiplied" or "straight". None: premultiplied in scene-linear floats, else straight, as in a PNG.
            Premultiplied codes are divided by alpha before they are decoded. Alpha itself is never decoded.
        rows
            "top-down", or "bottom-up" where the first row is the lowest of the picture.
        channels
            The names of the array's channels, in its order: "BGRA", ("R", "G", "B"); X is one to leave out.
        shape, row_bytes, dtype
            Of a flat buffer: (H, W) or (H, W, C); the bytes from one row's start to the next one's, negative where the
            first row is the last in memory, by default without gaps; the type of the numbers in a buffer of bytes.
        data_window, display_window
            (x, y, width, height), y down: the place of the pixels, by default at 0, 0; what is meant to be seen, by
            default the data window.

        Raises
        ------
        ArgumentError
            Another shape, length or dtype; an Image; an argument that does not fit; a uint8 or uint16 picture in a
            scene-linear space without an ``encoding``, where white would be 255 or 65535 times too bright: name the
            encoding, or divide; other whole numbers above 8.
        ColorError
            ``colorspace`` or ``encoding`` is no colour space, or finite numbers become NaN or Inf by it.
        """
        if isinstance(array, Exchange):
            raise ArgumentError("array: expected numbers, found an Image, which needs no making", parameter="array")
        source, said = Memory(array, shape, row_bytes, dtype, rows), Said(colorspace, encoding, alpha)
        parts, space = arrays.parts_of_array(source, type, channels, said, (data_window, display_window))
        return cls(*parts, colorspace=space)

    @overload
    def to_array(
        self,
        *,
        colorspace: ColorSpace | str | None = None,
        encoding: str | None = None,
        alpha: str | None = None,
        rows: str = "top-down",
        dtype: npt.DTypeLike | None = None,
        channels: Channels | None = None,
        out: None = None,
        row_bytes: None = None,
    ) -> npt.NDArray[Any]: ...

    @overload
    def to_array(
        self,
        *,
        colorspace: ColorSpace | str | None = None,
        encoding: str | None = None,
        alpha: str | None = None,
        rows: str = "top-down",
        dtype: npt.DTypeLike | None = None,
        channels: Channels | None = None,
        out: Out,
        row_bytes: int | None = None,
    ) -> Out: ...

    def to_array(
        self,
        *,
        colorspace: ColorSpace | str | None = None,
        encoding: str | None = None,
        alpha: str | None = None,
        rows: str = "top-down",
        dtype: npt.DTypeLike | None = None,
        channels: Channels | None = None,
        out: Any = None,
        row_bytes: int | None = None,
    ) -> Any:
        """Return the pixels as a host holds them, (H, W, C): the way back from :meth:`from_array`.

        Where nothing has to be converted, and there is no ``out``, the result is a read-only view of ``pixels``.

        Parameters
        ----------
        colorspace, encoding, alpha, rows
            As :meth:`from_array` takes them: the same ones give back what went in. ``colorspace`` None is the image's
            own, and beside an ``encoding`` other than "linear" it changes nothing. They say nothing of a matte's
            values. Colours stay undivided where alpha is 0 or less.
        dtype
            float32 (ids: uint32) unless given; that of ``out``. Color, mono and matte are rounded and clipped to
            uint8 or uint16, where NaN is 0; other types are never scaled. Half floats end at 65504.
        channels
            Names in the order wanted, "BGRA", ("Z",); the image's own unless given. A, where the image has none, and X
            are 1; R, G and B of a mono or matte are its one channel.
        out
            A host's memory to write to, and to return: an array (H, W, C) with any strides, or a flat buffer of that
            many numbers, a 1-D array, ctypes, a memoryview.
        row_bytes
            Of a flat ``out``, as :meth:`from_array` takes it.

        Raises
        ------
        ArgumentError
            A flat buffer of another length, an array of another shape, memory that is read-only, channels that there
            are not; whole numbers without an ``encoding`` for colours, or that do not hold the values of an id or data.
        ColorError
            As :meth:`from_array`.
        """
        said, names = Said(colorspace, encoding, alpha), tuple(self.spec.channelnames)
        image = Shown(self.pixels, names, self.type, self.colorspace)
        if out is None and row_bytes is None:
            return arrays.array_of(image, said, rows, dtype, channels)
        if out is None:
            raise ArgumentError("row_bytes: expected a flat buffer as out, found none", parameter="row_bytes")
        arrays.fill(Memory(out, None, row_bytes, dtype, rows), image, said, channels)
        return out

    @classmethod
    def from_imagebuf(
        cls,
        buf: oiio.ImageBuf,
        colorspace: ColorSpace | str = "auto",
        *,
        type: PortType | None = None,
        layer: str = "",
    ) -> Self:
        """Return an image of an OpenImageIO ImageBuf, with its windows and metadata; channels are found by name.

        With ``type`` None nothing is lost: exactly R, G, B[, A] make a color image, flow.x, flow.y a flow, Y a mono,
        Z a depth, and so on, any others data with every channel. A ``type`` takes just its own channels of ``layer``
        ("" = the plain names).

        Color and mono are brought to scene-linear light, premultiplied. ``colorspace`` "auto" asks the metadata
        (:func:`flowabs_nodes.color.detect`); pixels of 8 or 16 bits about which it says nothing are sRGB. Otherwise it
        is the space or encoding of the pixels, as :meth:`from_array` takes it.

        Raises ArgumentError for a buffer without pixels, with an error, deep samples or several planes, and for one
        without the channels of ``type``; ColorError as :meth:`from_array`.
        """
        parts, space = convert.parts_of_imagebuf(buf, colorspace, type, layer)
        return cls(*parts, colorspace=space)

    def to_imagebuf(self) -> oiio.ImageBuf:
        """Return an ImageBuf of float pixels, uint32 of ids, with this image's channel names, windows and metadata.

        What the metadata say of colours is true of these pixels, scene-linear and premultiplied.
        """
        spec = convert.true_of_light(self.spec, self.type, self.colorspace)
        return convert.imagebuf_of(self.pixels, spec)
