"""The value that travels along every edge of a graph: pixels, an OpenImageIO ImageSpec, and the colour encoding."""

from __future__ import annotations

import copy

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color, image_convert
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image_parts import Origin, PixelSource, Window, check_parts
from flowabs_nodes.port_types import PORT_TYPES, PortType, pixel_type

__all__ = ["PORT_TYPES", "Image", "Origin", "PixelSource", "PortType", "Window"]


class Image:
    """Pixels on a data window, with metadata; never changed once made.

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
    expects
        Encodings whose code values will be asked for after those of the lightness: both are then made together.
    keeps_codes
        False where code values will be asked for only once more: they are then not kept.

    :meth:`encoded` returns code values, which are made once and shared by all callers.
    """

    expects: frozenset[str] = frozenset()
    keeps_codes: bool = True

    def __init__(
        self,
        pixels: Array | None,
        spec: oiio.ImageSpec,
        type: PortType,
        *,
        colorspace: color.ColorSpace | str = "lin_rec709",
        origin: Origin | None = None,
    ) -> None:
        check_parts(pixels, spec, type)
        self.type: PortType = type
        self.colorspace = color.space(colorspace)
        self.origin = origin
        self._spec = spec
        self._pixels = None if pixels is None else pixel_type(type).cast(pixels)
        self._deferred: PixelSource | None = None
        self._codes: dict[tuple[str, float | None], Array] = {}
        self._monos: dict[tuple[str, float | None], Array] = {}
        self._alpha: Array | None = None
        self._alpha_known = False

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

    # ------------------------------------------------------------------ pixels and code values

    @property
    def pixels(self) -> Array:
        """Return (H, W, C) in the type's dtype, decoded on first use where a filter left code values."""
        if self._pixels is None:
            assert self._deferred is not None
            self._pixels = self._deferred.decode(self.colorspace)
        return self._pixels

    @property
    def deferred(self) -> PixelSource | None:
        """Return the source that pixels are computed from where a filter left code values, else None."""
        return self._deferred

    @property
    def alpha(self) -> Array | None:
        """Return the coverage (H, W), or None where the image is opaque: no A, or A = 1 in every pixel."""
        if not self._alpha_known:
            if "A" in self.channels and self.type == "color":
                pixels = self._deferred.codes.under if self._deferred else self._pixels
                assert pixels is not None
                alpha = np.ascontiguousarray(pixels[..., 3])
                self._alpha = None if bool((alpha == 1).all()) else alpha
            self._alpha_known = True
        return self._alpha

    def encoded(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """Return the code values of a color image, (H, W, 3) float32.

        Without ``ground`` they are those of rgb / A, which filtering nodes work on (of black where A = 0). With
        ``ground`` they are those of rgb + (1 - A) ground, which analysis nodes see. Of an opaque image both are the
        same array.
        """
        self._needs_color("encoded")
        ground = None if self.alpha is None else ground
        own = self._own_codes(space) if ground is None else None
        if own is not None:
            return own
        if (space, ground) not in self._codes:
            self._encode(space, ground, mono=False)
        return self._forgotten_unless_kept(self._codes[space, ground])

    def encoded_mono(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """Return the code values of the lightness, (H, W) float32: L* (lab), or ACEScct of the AP1 luminance (acescct).

        ``ground`` is as in :meth:`encoded`.
        """
        self._needs_color("encoded_mono")
        ground = None if self.alpha is None else ground
        if (space, ground) not in self._monos:
            own = self._own_codes(space) if ground is None and space == "lab" else None
            if own is not None:
                self._monos[space, ground] = np.ascontiguousarray(own[..., 0])
            else:
                self._encode(space, ground, codes=ground is None and space in self.expects)
        return self._forgotten_unless_kept(self._monos[space, ground])

    def _forgotten_unless_kept(self, codes: Array) -> Array:
        """Return ``codes``; forget all code values unless the image keeps them."""
        if not self.keeps_codes:
            self._codes.clear()
            self._monos.clear()
        return codes

    def _encode(self, space: str, ground: float | None, *, codes: bool = True, mono: bool = True) -> None:
        """Make and keep the code values of all channels, of the lightness, or both in one pass."""
        from flowabs_nodes.color.codes import BARE, encoded

        codes = codes and (space, ground) not in self._codes
        behind = BARE if ground is None else ground
        colors, lightness = encoded(self.pixels, space, self.colorspace, ground=behind, codes=codes, mono=mono)
        if codes:
            self._codes[space, ground] = colors
        if mono:
            self._monos[space, ground] = lightness

    def _own_codes(self, space: str) -> Array | None:
        """Return the code values of ``space`` that pixels are to be decoded from, if no operation is deferred."""
        deferred = self._deferred
        plain = deferred is not None and deferred.codes is deferred
        return deferred.codes.values if deferred is not None and plain and deferred.codes.space == space else None

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
        pixels = declared.cast(pixels if pixels.ndim == 3 else pixels[..., None])
        count = pixels.shape[2]
        if channels is None and declared.channels:
            channels = declared.channel_names(count)
        elif channels is None and count == len(self.channels):
            channels = self.channels
        if channels is None:
            raise ArgumentError(f"{count} channels do not make {declared.an_image}", parameter="pixels")
        spec = image_convert.with_channels(self._spec, channels)
        spec.height, spec.width = pixels.shape[:2]
        return Image(pixels, spec, type, colorspace=self.colorspace, origin=self.origin)

    def with_codes(self, codes: Array, space: str) -> Image:
        """Return an image with new colours, the code values (H, W, 3) of rgb / A; alpha and pixels with A = 0 stay.

        The code values are decoded when ``pixels`` are asked for; a following filter in the same space never asks.
        """
        self._needs_color("with_codes")
        under = None
        if "A" in self.channels:
            deferred = self._deferred
            plain = deferred is not None and deferred.codes is deferred
            under = deferred.codes.under if deferred is not None and plain else self.pixels
        from flowabs_nodes.color.codes import Codes  # numba, which an image without code values does not need

        return self.with_deferred(Codes(np.ascontiguousarray(codes, np.float32), space, under))

    def with_deferred(self, deferred: PixelSource) -> Image:
        """Return an image whose pixels are computed by ``deferred``, which must have this image's alpha."""
        image = Image(None, self._spec, "color", colorspace=self.colorspace, origin=self.origin)
        image._deferred = deferred
        image._alpha, image._alpha_known = self.alpha, True
        return image

    def alone(self) -> Image:
        """Return a copy that shares pixels; code values made for it from now on are its own, and are freed with it."""
        image = copy.copy(self)
        image._codes, image._monos = dict(self._codes), dict(self._monos)
        return image

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
        pixels = image_convert.on_window(self.pixels, self.data_window, window, pixel_type(self.type).outside)
        spec = self.spec
        spec.x, spec.y, spec.width, spec.height = window
        return Image(pixels, spec, self.type, colorspace=self.colorspace, origin=self.origin)

    # ------------------------------------------------------------------ from and to arrays and ImageBufs

    @classmethod
    def from_array(
        cls,
        array: npt.ArrayLike,
        colorspace: color.ColorSpace | str = "lin_rec709",
        *,
        type: PortType | None = None,
        channels: tuple[str, ...] | None = None,
    ) -> Image:
        """Return an image of (H, W) or (H, W, C) numbers, which are copied.

        One channel is mono, two are flow, three or four color, unless ``type`` says else. Color is scene-linear RGB or
        premultiplied RGBA in ``colorspace``. ``data`` takes any channels, with any names; ids are whole numbers.
        """
        return cls(*image_convert.parts_of_array(array, type, channels), colorspace=colorspace)

    @classmethod
    def from_imagebuf(
        cls,
        buf: oiio.ImageBuf,
        colorspace: color.ColorSpace | str = "auto",
        *,
        type: PortType | None = None,
        layer: str = "",
    ) -> Image:
        """Return an image of an OpenImageIO ImageBuf, with its windows and metadata; channels are found by name.

        With ``type`` None nothing is lost: exactly R, G, B[, A] make a color image, flow.x, flow.y a flow, Y a mono,
        Z a depth, and so on, any others data with every channel. A ``type`` takes just its own channels of ``layer``
        ("" = the plain names). ``colorspace`` "auto" asks the metadata (:func:`flowabs_nodes.color.detect`).
        """
        parts = image_convert.parts_of_imagebuf(buf, type, layer)
        if str(colorspace) == "auto" or colorspace is None:
            colorspace = color.detect(buf.spec()).space
        return cls(*parts, colorspace=colorspace)

    def to_imagebuf(self) -> oiio.ImageBuf:
        """Return an ImageBuf of float pixels, uint32 of ids, with this image's channel names, windows and metadata."""
        spec = self.spec
        if self.type == "color":
            spec.attribute("oiio:ColorSpace", self.colorspace.name)
        return image_convert.imagebuf_of(self.pixels, spec)
