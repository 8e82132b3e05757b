"""The value that travels along every edge of a graph: pixels, an OpenImageIO ImageSpec, and the colour encoding."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, cast

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError, nearest

if TYPE_CHECKING:
    from flowabs_nodes.color.codes import Codes

PortType = Literal["color", "mono", "matte", "flow", "data"]
PORT_TYPES: tuple[PortType, ...] = ("color", "mono", "matte", "flow", "data")

#: Channel names of each port type; ``data`` has any.
CHANNELS: dict[str, tuple[tuple[str, ...], ...]] = {
    "color": (("R", "G", "B"), ("R", "G", "B", "A")),
    "mono": (("Y",),),
    "matte": (("Y",),),
    "flow": (("flow.x", "flow.y"),),
}


class Window(NamedTuple):
    """A rectangle of pixels: the corner's place and the size. May be negative in x and y."""

    x: int
    y: int
    width: int
    height: int


class PixelSource(Protocol):
    """Pixels that are made once somebody asks for them: of code values, by decoding and perhaps more."""

    @property
    def codes(self) -> Codes:
        """The code values that it begins with; itself, where nothing but decoding is to be done."""

    def decode(self, colorspace: color.ColorSpace) -> Array:
        """Return the pixels, (H, W, 3), or premultiplied (H, W, 4)."""


@dataclass(frozen=True)
class Origin:
    """The file an image was read from.

    ``part`` is its index there, ``layer`` the layer and ``channels`` the channels that were taken. ``alpha`` names the
    file's alpha where the image leaves it out (ignored, or 0 in every pixel): what is written gets it back as it was.
    """

    file: str
    part: int = 0
    layer: str = ""
    channels: tuple[str, ...] = ()
    alpha: str = ""


class Image:
    """Pixels on a data window, with metadata; never changed once made.

    Attributes
    ----------
    type
        Port type: "color", "mono", "matte", "flow" or "data".
    spec
        OpenImageIO's ImageSpec: channel names, data window, display window, metadata, and as ``format`` the data
        type of the file it came from. A copy is handed out: the image's own never changes.
    colorspace
        The scene-linear space of a color image's RGB.
    origin
        The file the plate came from, if it came from one.

    ``pixels`` is (H, W, C) float32: scene-linear premultiplied for color, as they are for all else.
    :meth:`encoded` gives code values, made once and shared by everything that asks for the same.

    Two things are for who knows what comes next. ``expects``: spaces whose code values somebody will want after those
    of the lightness, so that both are best made together. ``keeps_codes``: False where nobody asks for any again.
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
        if type not in PORT_TYPES:
            raise ArgumentError(f"{type!r} is not a port type", hint=nearest(type, PORT_TYPES), parameter="type")
        names = tuple(spec.channelnames)
        if type in CHANNELS and names not in CHANNELS[type]:
            expected = " or ".join(",".join(channels) for channels in CHANNELS[type])
            raise ArgumentError(f"a {type} image has the channels {expected}, not {','.join(names)}", parameter="spec")
        if pixels is not None and pixels.shape != (spec.height, spec.width, len(names)):
            raise ArgumentError(
                f"pixels of shape {pixels.shape} do not fit a data window of {spec.width}x{spec.height} "
                f"with {len(names)} channels",
                parameter="pixels",
            )
        self.type: PortType = type
        self.colorspace = color.space(colorspace)
        self.origin = origin
        self._spec = spec
        self._pixels = None if pixels is None else np.ascontiguousarray(pixels, np.float32)
        self._deferred: PixelSource | None = None
        self._codes: dict[tuple[str, float | None], Array] = {}
        self._monos: dict[tuple[str, float | None], Array] = {}
        self._alpha: Array | None = None
        self._alpha_known = False

    # ------------------------------------------------------------------ what it is

    @property
    def spec(self) -> oiio.ImageSpec:
        return oiio.ImageSpec(self._spec)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names, in the order of the pixels' last axis."""
        return tuple(self._spec.channelnames)

    @property
    def data_window(self) -> Window:
        """Where the pixels are."""
        return Window(self._spec.x, self._spec.y, self._spec.width, self._spec.height)

    @property
    def display_window(self) -> Window:
        """What of the plane is meant to be seen."""
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
        """(H, W, C) float32; decoded from code values the first time, where a filter left those."""
        if self._pixels is None:
            assert self._deferred is not None
            self._pixels = self._deferred.decode(self.colorspace)
        return self._pixels

    @property
    def deferred(self) -> PixelSource | None:
        """What pixels are made of where a filter left code values, else None."""
        return self._deferred

    @property
    def alpha(self) -> Array | None:
        """(H, W) coverage, or None where the image is opaque: no A, or A = 1 in every pixel."""
        if not self._alpha_known:
            if "A" in self.channels and self.type == "color":
                pixels = self._deferred.codes.under if self._deferred else self._pixels
                assert pixels is not None
                alpha = np.ascontiguousarray(pixels[..., 3])
                self._alpha = None if bool((alpha == 1).all()) else alpha
            self._alpha_known = True
        return self._alpha

    def encoded(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """(H, W, 3) float32 code values of a color image.

        Without ``ground``: of rgb / A, what smoothing nodes work on (where A = 0, of black). With it: of
        rgb + (1 - A) ground, what looking nodes see. The same array when the image is opaque.
        """
        self._needs_color("encoded")
        ground = None if self.alpha is None else ground
        own = self._own_codes(space) if ground is None else None
        if own is not None:
            return own
        if (space, ground) not in self._codes:
            self._encode(space, ground, mono=False)
        return self._handed_out(self._codes[space, ground])

    def encoded_mono(self, space: str = "lab", *, ground: float | None = None) -> Array:
        """(H, W) float32 code values of the lightness: L* (lab), or ACEScct of the AP1 luminance (acescct)."""
        self._needs_color("encoded_mono")
        ground = None if self.alpha is None else ground
        if (space, ground) not in self._monos:
            own = self._own_codes(space) if ground is None and space == "lab" else None
            if own is not None:
                self._monos[space, ground] = np.ascontiguousarray(own[..., 0])
            else:
                self._encode(space, ground, codes=ground is None and space in self.expects)
        return self._handed_out(self._monos[space, ground])

    def _handed_out(self, codes: Array) -> Array:
        if not self.keeps_codes:
            self._codes.clear()
            self._monos.clear()
        return codes

    def _encode(self, space: str, ground: float | None, *, codes: bool = True, mono: bool = True) -> None:
        """Make code values of all channels, of the lightness, or both in one go."""
        from flowabs_nodes.color.codes import BARE, encoded

        codes = codes and (space, ground) not in self._codes
        behind = BARE if ground is None else ground
        colors, lightness = encoded(self.pixels, space, self.colorspace, ground=behind, codes=codes, mono=mono)
        if codes:
            self._codes[space, ground] = colors
        if mono:
            self._monos[space, ground] = lightness

    def _own_codes(self, space: str) -> Array | None:
        """Return the code values that pixels are yet to be made of, if nothing else is to be done with them."""
        deferred = self._deferred
        plain = deferred is not None and deferred.codes is deferred
        return deferred.codes.values if deferred is not None and plain and deferred.codes.space == space else None

    def _needs_color(self, what: str) -> None:
        if self.type != "color":
            raise ArgumentError(f"{what}: only color images have code values, this one is {self.type}")

    # ------------------------------------------------------------------ one image from another

    def with_pixels(
        self, pixels: Array, type: PortType | None = None, channels: tuple[str, ...] | None = None
    ) -> Image:
        """New pixels on the same windows with the same metadata; ``type`` as this image's unless given.

        Channel names follow from the type and the number of channels; ``data`` keeps its own or takes ``channels``.
        """
        type = self.type if type is None else type
        pixels = np.ascontiguousarray(pixels if pixels.ndim == 3 else pixels[..., None], np.float32)
        count = pixels.shape[2]
        if channels is None and type in CHANNELS:
            channels = next((names for names in CHANNELS[type] if len(names) == count), None)
        elif channels is None and count == len(self.channels):
            channels = self.channels
        if channels is None:
            raise ArgumentError(f"{count} channels do not make a {type} image", parameter="pixels")
        spec = _with_channels(self._spec, channels)
        spec.height, spec.width = pixels.shape[:2]
        return Image(pixels, spec, type, colorspace=self.colorspace, origin=self.origin)

    def with_codes(self, codes: Array, space: str) -> Image:
        """New colour from code values of rgb / A; alpha as it was, and pixels with A = 0 come out as they went in.

        They are decoded when somebody asks for ``pixels``; a next filter in the same space never does.
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
        """New colour, as :meth:`with_codes`; what is ``under`` it has this image's alpha."""
        image = Image(None, self._spec, "color", colorspace=self.colorspace, origin=self.origin)
        image._deferred = deferred
        image._alpha, image._alpha_known = self.alpha, True
        return image

    def alone(self) -> Image:
        """The same image; code values that are asked of it from now on are its own, and go with it."""
        image = copy.copy(self)
        image._codes, image._monos = dict(self._codes), dict(self._monos)
        return image

    def as_type(self, type: PortType) -> Image:
        """Widened to what a port asks for: matte to mono as it is, either to color as R = G = B."""
        if type == self.type:
            return self
        if self.type == "matte" and type == "mono":
            return self.with_pixels(self.pixels, "mono")
        if self.type in ("matte", "mono") and type == "color":
            return self.with_pixels(np.repeat(self.pixels, 3, axis=2), "color")
        raise ArgumentError(f"a {self.type} image cannot go where {type} is asked for")

    def on_window(self, window: Window) -> Image:
        """The same image on another data window: cut, and 0 where it has no pixels."""
        if window == self.data_window:
            return self
        x, y, width, height = self.data_window
        pixels = np.zeros((window.height, window.width, len(self.channels)), np.float32)
        x0, x1 = max(x, window.x), min(x + width, window.x + window.width)
        y0, y1 = max(y, window.y), min(y + height, window.y + window.height)
        if x0 < x1 and y0 < y1:
            pixels[y0 - window.y : y1 - window.y, x0 - window.x : x1 - window.x] = self.pixels[
                y0 - y : y1 - y, x0 - x : x1 - x
            ]
        spec = self.spec
        spec.x, spec.y, spec.width, spec.height = window
        return Image(pixels, spec, self.type, colorspace=self.colorspace, origin=self.origin)

    # ------------------------------------------------------------------ to and from arrays and ImageBuf

    @classmethod
    def from_array(
        cls,
        array: npt.ArrayLike,
        colorspace: color.ColorSpace | str = "lin_rec709",
        *,
        type: PortType | None = None,
        channels: tuple[str, ...] | None = None,
    ) -> Image:
        """From (H, W) or (H, W, C): one channel is mono, two are flow, three or four color, unless ``type`` says else.

        Color is scene-linear RGB or premultiplied RGBA in ``colorspace``. ``data`` takes any channels, with names.
        """
        pixels = np.asarray(array)
        if pixels.ndim not in (2, 3) or pixels.size == 0 or pixels.dtype.kind not in "fiub":
            raise ArgumentError(
                f"expected numbers of shape (H, W) or (H, W, C), found {pixels.dtype} {pixels.shape}", parameter="array"
            )
        pixels = np.array(pixels if pixels.ndim == 3 else pixels[..., None], np.float32, order="C")
        count = pixels.shape[2]
        if type is None:
            guess = {1: "mono", 2: "flow", 3: "color", 4: "color"}.get(count, "data")
            type = "data" if channels is not None and channels not in CHANNELS.get(guess, ()) else cast(PortType, guess)
        if channels is None:
            known = next((names for names in CHANNELS.get(type, ()) if len(names) == count), None)
            channels = known if known is not None else tuple(f"channel{i}" for i in range(count))
        spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], count, "float")
        return cls(pixels, _with_channels(spec, channels), type, colorspace=colorspace)

    @classmethod
    def from_imagebuf(
        cls,
        buf: oiio.ImageBuf,
        colorspace: color.ColorSpace | str = "auto",
        *,
        type: PortType | None = None,
        layer: str = "",
    ) -> Image:
        """From an OpenImageIO ImageBuf, with its windows and metadata; channels are found by name.

        With ``type`` None nothing is lost: exactly R, G, B[, A] make a color image, flow.x, flow.y a flow, Y a
        mono, and anything else data with every channel. A ``type`` takes just its own channels of ``layer``
        ("" = the plain names).
        ``colorspace`` "auto" asks the metadata (:func:`flowabs_nodes.color.detect`).
        """
        spec = buf.spec()
        pixels = buf.get_pixels(oiio.FLOAT)
        if buf.has_error or pixels is None or spec.deep:
            found = "deep samples" if spec.deep else (buf.geterror() or "no pixels")
            raise ArgumentError(f"an ImageBuf with flat pixels is expected, found {found}", parameter="buf")
        pixels = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, spec.nchannels)
        if str(colorspace) == "auto" or colorspace is None:
            colorspace = color.detect(spec).space
        names = tuple(spec.channelnames)
        prefix = f"{layer}." if layer else ""
        candidates = {name: kinds for name, kinds in CHANNELS.items() if name != "matte" and type in (None, name)}
        if type == "matte":
            candidates = {"matte": CHANNELS["matte"]}
        for kind, sets in candidates.items():
            for wanted in reversed(sets):
                picks = [prefix + name for name in wanted]
                if set(picks) == set(names) or (type is not None and set(picks) <= set(names)):
                    chosen = np.ascontiguousarray(pixels[..., [names.index(pick) for pick in picks]])
                    return cls(chosen, _with_channels(spec, wanted), cast(PortType, kind), colorspace=colorspace)
        if type not in (None, "data"):
            expected = " or ".join(",".join(prefix + n for n in sets) for sets in CHANNELS[cast(str, type)])
            raise ArgumentError(f"no channels {expected}; the buffer has {','.join(names)}", parameter="buf")
        return cls(np.ascontiguousarray(pixels), _with_channels(spec, names), "data", colorspace=colorspace)

    def to_imagebuf(self) -> oiio.ImageBuf:
        """An ImageBuf of float pixels with this image's channel names, windows and metadata."""
        spec = self.spec
        spec.set_format(oiio.FLOAT)
        if self.type == "color":
            spec.attribute("oiio:ColorSpace", self.colorspace.name)
        buf = oiio.ImageBuf(spec)
        buf.set_pixels(buf.roi, self.pixels)
        return buf


def _with_channels(spec: oiio.ImageSpec, names: tuple[str, ...]) -> Any:
    """A copy of ``spec`` with these channels, all of one data type; the file's tiling does not stay."""
    copy = oiio.ImageSpec(spec)
    copy.nchannels = len(names)
    copy.channelnames = names
    copy.channelformats = ()
    copy.alpha_channel = names.index("A") if "A" in names else -1
    copy.z_channel = -1
    return copy
