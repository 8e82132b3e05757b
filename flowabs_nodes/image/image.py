"""The value that travels along every edge of a graph: pixels, an OpenImageIO ImageSpec, and the colour encoding."""

from __future__ import annotations

from typing import Any, overload

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color, encodings
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import convert, preview, state
from flowabs_nodes.image.exchange import Exchange
from flowabs_nodes.image.parts import Origin, PixelSource, Window, as_pixels, check_parts, with_channels
from flowabs_nodes.port_types import PORT_TYPES, PortType, pixel_type
from flowabs_nodes.simd.read_only import read_only

__all__ = ["PORT_TYPES", "Image", "Origin", "PixelSource", "PortType", "Window"]


class Image(Exchange):
    """Pixels on a data window, with metadata: a value, which nothing changes.

    Setting an attribute raises AttributeError, and every array that an image gives is read-only. An image can be
    pickled and copied. ``pixels`` of the constructor are (H, W, C) float32, or a source to compute them from; they are
    not copied, and must not be changed any more.

    Attributes
    ----------
    type
        Port type, one of :data:`flowabs_nodes.port_types.TYPES`: "color", "mono", "depth" ...
    spec
        A copy of the OpenImageIO ImageSpec: channel names, data window, display window, metadata, and as ``format`` the
        data type of the file that the image came from.
    colorspace
        The scene-linear space of a color image's RGB.
    origin
        The file that the plate came from, if it came from one.
    pixels
        (H, W, C) float32, of ids uint32: scene-linear premultiplied for color, unconverted for all other types.

    Decoded ``pixels``, ``alpha`` and what :meth:`encoded` and its neighbours return are computed once in an
    evaluation of a graph, and each time that they are asked for outside of one
    (:mod:`~flowabs_nodes.encodings`).
    """

    __slots__ = ("__weakref__", "_source", "_spec", "colorspace", "origin", "type")

    type: PortType
    colorspace: color.ColorSpace
    origin: Origin | None
    _source: Array | PixelSource
    _spec: oiio.ImageSpec

    def __init__(
        self,
        pixels: Array | PixelSource,
        spec: oiio.ImageSpec,
        type: PortType,
        *,
        colorspace: color.ColorSpace | str = "lin_rec709",
        origin: Origin | None = None,
    ) -> None:
        check_parts(pixels, spec, type)
        plain = isinstance(pixels, np.ndarray)
        values = {
            "_source": read_only(as_pixels(pixels, type)) if plain else pixels,
            "_spec": oiio.ImageSpec(spec),
            "type": type,
            "colorspace": color.space(colorspace),
            "origin": origin,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"an Image never changes: {name} cannot be set (with_pixels and others make a new one)")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"an Image never changes: {name} cannot be deleted")

    def __copy__(self) -> Image:
        """Return another image of the same pixels."""
        return self._with_source(self._source)

    def __getstate__(self) -> dict[str, Any]:
        return state.packed(self.pixels, self._spec, self.type, self.colorspace, self.origin)

    def __setstate__(self, packed: Any) -> None:
        """Become the image that was pickled; FlowabsError for one of a version that is not known here."""
        parts, colorspace, origin = state.unpacked(packed)
        Image.__init__(self, *parts, colorspace=colorspace, origin=origin)

    # ------------------------------------------------------------------ header

    @property
    def spec(self) -> oiio.ImageSpec:
        """Return a copy of the header."""
        return oiio.ImageSpec(self._spec)

    @property
    def channels(self) -> tuple[str, ...]:
        """Return the channel names, in the order of the pixels' last axis."""
        return tuple(self._spec.channelnames)

    @property
    def data_window(self) -> Window:
        """Return the window that the pixels cover."""
        return Window(self._spec.x, self._spec.y, self._spec.width, self._spec.height)

    @property
    def display_window(self) -> Window:
        """Return the window that is meant to be seen."""
        spec = self._spec
        return Window(spec.full_x, spec.full_y, spec.full_width, spec.full_height)

    def __repr__(self) -> str:
        data, display = self.data_window, self.display_window
        extra = f" of {self.colorspace.name}" if self.type == "color" else ""
        return (
            f"<Image {self.type}{extra}, {data.width}x{data.height}{data.x:+d}{data.y:+d}, "
            f"display {display.width}x{display.height}{display.x:+d}{display.y:+d}, {','.join(self.channels)}>"
        )

    def _repr_png_(self) -> bytes:
        """Return a small picture of the image, which notebooks show: see :mod:`flowabs_nodes.image.preview`."""
        return preview.png(self)

    # ------------------------------------------------------------------ pixels and code values

    @property
    def pixels(self) -> Array:
        """Return (H, W, C) in the type's dtype, read-only; decoded where a filter left code values."""
        return self._source if isinstance(self._source, np.ndarray) else encodings.current().pixels(self)

    @overload
    def __array__(self, dtype: None = None, copy: bool | None = None) -> Array: ...

    @overload
    def __array__(self, dtype: npt.DTypeLike, copy: bool | None = None) -> npt.NDArray[Any]: ...

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """Return ``pixels``, (H, W, C), for ``np.asarray(image)``: read-only where they need no copy.

        Raises ValueError, as NumPy does, where ``copy`` is False and another ``dtype`` needs one.
        """
        pixels = self.pixels
        if copy is False and dtype is not None and np.dtype(dtype) != pixels.dtype:
            raise ValueError(
                f"the pixels are {pixels.dtype}: {np.dtype(dtype)} needs a copy, and copy=False forbids it"
            )
        wanted = pixels if dtype is None else pixels.astype(dtype, copy=False)
        return wanted.copy() if copy and wanted is pixels else wanted

    @property
    def deferred(self) -> PixelSource | None:
        """Return the source that pixels are computed from where a filter left code values, else None."""
        return None if isinstance(self._source, np.ndarray) else self._source

    @property
    def alpha(self) -> Array | None:
        """Return the coverage (H, W), or None where the image is opaque: no A, or A = 1 in every pixel."""
        return encodings.current().alpha(self)

    def encoded(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """Return the code values of a color image, (H, W, 3) float32, read-only.

        Without ``ground`` they are those of rgb / A, which filtering nodes work on (of black where A = 0). With
        ``ground`` they are those of rgb + (1 - A) ground, which analysis nodes see. Of an opaque image both are the
        same.
        """
        self._needs_color("encoded")
        return encodings.current().codes(self, space, ground)

    def encoded_mono(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """Return the code values of the lightness, (H, W) float32: L* (lab), or ACEScct of the AP1 luminance (acescct).

        ``ground`` is as in :meth:`encoded`.
        """
        self._needs_color("encoded_mono")
        return encodings.current().mono(self, space, ground)

    def encoded_opponent(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """Return lightness as :meth:`encoded_mono` does, and two channels of colour, (H, W, 3) float32, read-only.

        They are a* and b* (lab), or red and blue less lightness (acescct). ``ground`` is as in :meth:`encoded`.
        """
        self._needs_color("encoded_opponent")
        return encodings.current().opponent(self, space, ground)

    def _needs_color(self, what: str) -> None:
        """Raise ArgumentError if the image has no code values."""
        if self.type != "color":
            raise ArgumentError(f"{what}: only color images have code values, this one is {self.type}")

    # ------------------------------------------------------------------ one image from another

    def with_pixels(
        self, pixels: Array, type: PortType | None = None, channels: tuple[str, ...] | None = None
    ) -> Image:
        """Return an image of new pixels, (H, W) or (H, W, C), with the same windows and metadata.

        The type is this image's unless given. Channel names follow from the type and the number of channels; ``data``
        keeps this image's names or takes ``channels``.
        """
        type = self.type if type is None else type
        declared = pixel_type(type)
        pixels = as_pixels(pixels, type)
        pixels = pixels if pixels.ndim == 3 else pixels[..., None]
        count = pixels.shape[2]
        if channels is None and declared.channels:
            channels = declared.channel_names(count)
        elif channels is None and count == len(self.channels):
            channels = self.channels
        if channels is None:
            raise ArgumentError(f"{count} channels do not make {declared.an_image}", parameter="pixels")
        spec = with_channels(self._spec, channels)
        spec.height, spec.width = pixels.shape[:2]
        return Image(pixels, spec, type, colorspace=self.colorspace, origin=self.origin)

    def with_codes(self, codes: Array, space: str) -> Image:
        """Return an image with new colours, the code values (H, W, 3) of rgb / A; alpha and pixels with A = 0 stay.

        The code values are decoded when ``pixels`` are asked for; a following filter in the same space never asks.
        """
        self._needs_color("with_codes")
        under = None
        if "A" in self.channels:
            source = self.deferred
            under = source.codes.under if source is not None and source.codes is source else self.pixels
        from flowabs_nodes.color.codes import Codes  # numba, which an image without code values does not need

        return self.with_deferred(Codes(read_only(as_pixels(codes, "color")), space, under))

    def with_deferred(self, deferred: PixelSource) -> Image:
        """Return an image whose pixels are computed by ``deferred``, which must have this image's alpha."""
        self._needs_color("with_deferred")
        image = self._with_source(deferred)
        encodings.current().share_alpha(image, self)
        return image

    def decoded(self) -> Image:
        """Return the image with its pixels computed, so that it holds no code values."""
        return self if self.deferred is None else self._with_source(self.pixels)

    def _with_source(self, source: Array | PixelSource) -> Image:
        """Return an image like this one with other pixels of the same channels and windows."""
        return Image(source, self._spec, self.type, colorspace=self.colorspace, origin=self.origin)

    def as_type(self, type: PortType) -> Image:
        """Return the image as a port's type: a matte as mono, unchanged; a matte or mono as color, R = G = B."""
        if type == self.type:
            return self
        if type in pixel_type(self.type).widens_to:
            count = len(pixel_type(type).typical_channels)
            return self.with_pixels(self.pixels if count == 1 else np.repeat(self.pixels, count, axis=2), type)
        raise ArgumentError(f"{pixel_type(self.type).an_image} cannot go where {type} is asked for")

    def on_window(self, window: Window) -> Image:
        """Return the image on another data window: cut, and its type's value for outside where it had no pixels."""
        if window == self.data_window:
            return self
        pixels = convert.on_window(self.pixels, self.data_window, window, pixel_type(self.type).outside)
        spec = self.spec
        spec.x, spec.y, spec.width, spec.height = window
        return Image(pixels, spec, self.type, colorspace=self.colorspace, origin=self.origin)
