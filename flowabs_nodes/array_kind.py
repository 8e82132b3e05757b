"""Tells what the numbers of a picture in an array mean, makes an Image of it, and an array of the same kind again."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import named
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image

log = logging.getLogger("flowabs")

#: The modes of a Pillow image whose array is a picture as it stands: no palette, no CMYK.
_PILLOW_MODES = ("L", "RGB", "RGBA", "I;16", "F")


@dataclass(frozen=True)
class ArrayKind:
    """The kind of a picture's array: its dtype, uint8, uint16 or a float; and the encoding of its numbers."""

    dtype: np.dtype[Any]
    encoding: str

    @property
    def white(self) -> float:
        """Return the number that stands for 1."""
        return 1.0 if self.dtype.kind == "f" else float(np.iinfo(self.dtype).max)

    @property
    def premultiplied(self) -> bool:
        """Return True where colours are multiplied by alpha: in floats of scene-linear light."""
        return self.dtype.kind == "f" and named.find(self.encoding).kind == "linear"

    def image(self, array: npt.NDArray[Any]) -> Image:
        """Return the color image of an array (H, W), (H, W, 1), (H, W, 3) or (H, W, 4) of this kind."""
        pixels = np.atleast_3d(array).astype(np.float32) / np.float32(self.white)
        pixels = np.repeat(pixels, 3, axis=2) if pixels.shape[2] == 1 else pixels
        pixels, space = color.ocio.linearize(pixels, self.encoding)
        if pixels.shape[2] == 4 and not self.premultiplied:
            pixels[..., :3] *= pixels[..., 3:]
        return Image.from_array(pixels, space)

    def array(self, image: Image, like: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return what was drawn of the array ``like``, in its shape and with its alpha.

        Colours are encoded again; where alpha is 0 they stay what they were. A matte is no colour: its values are what
        they are, in every channel.
        """
        alpha = like[..., 3:].astype(np.float32) / np.float32(self.white) if like.shape[2:] == (4,) else None
        if image.type == "color":
            rgb = image.pixels[..., :3]
            if alpha is not None and not self.premultiplied:
                rgb = np.divide(rgb, alpha, out=np.zeros_like(rgb), where=alpha > 0)
            rgb = color.ocio.encode_named(rgb, image.colorspace, self.encoding)
        else:
            rgb = np.repeat(image.pixels, 3, axis=2) * (alpha if alpha is not None and self.premultiplied else 1)
        if like.ndim == 2 or like.shape[2] == 1:
            drawn = self._numbers(rgb.mean(axis=2)).reshape(like.shape)
        else:
            drawn = like.copy(order="C")
            seen = True if alpha is None else alpha > 0
            np.copyto(drawn[..., :3], self._numbers(rgb), where=seen)
        return drawn

    def _numbers(self, values: Array) -> npt.NDArray[Any]:
        """Return values, white at 1, in this dtype: whole numbers rounded and clipped."""
        if self.dtype.kind == "f":
            most = np.finfo(self.dtype).max
            return values.clip(-most, most).astype(self.dtype)
        return np.rint(values.clip(0, 1) * self.white).astype(self.dtype)


def array_and_kind(rgb: Any, encoding: str | None, caller: str) -> tuple[npt.NDArray[Any], ArrayKind]:
    """Return a picture as a NumPy array, and its kind.

    Parameters
    ----------
    rgb
        An array, an Image, an ImageBuf, or anything else that NumPy can read.
    encoding
        The name of its encoding. Without it whole numbers are sRGB and floats scene-linear Rec.709, an Image's in its
        own space; floats from 0 to 1, which may well be sRGB, are taken so with a warning to the logger "flowabs".
    caller
        Who asks, for the warning.

    Raises
    ------
    ArgumentError
        For another shape or dtype, and floats that are whole numbers up to 255 or the like. The hint is the cure.
    """
    if isinstance(rgb, Image):
        encoding = encoding or rgb.colorspace.name
    array = _array(rgb)
    if encoding is not None and not isinstance(encoding, str):
        raise ArgumentError(
            f'encoding: expected a name such as "sRGB" or "linear", found {encoding!r}',
            code="wrong-type",
            parameter="encoding",
        )
    if array.dtype.kind != "f" and array.dtype not in (np.uint8, np.uint16):
        found = array.dtype if array.dtype.kind in "iub" else type(rgb).__name__
        raise ArgumentError(
            f"rgb: expected uint8, uint16 or floats, found {found}",
            code="wrong-type",
            hint="rgb.astype(np.uint8), if white is 255" if array.dtype.kind in "iu" else "",
            parameter="rgb",
        )
    _check_shape(array)
    floats = array.dtype.kind == "f"
    if floats and array.max() > 8 and bool((array == np.rint(array)).all()):
        raise ArgumentError(
            f"rgb: expected floats with white at 1, found whole numbers up to {array.max():g}",
            hint=f"divide by {255 if array.max() <= 255 else 65535}",
            parameter="rgb",
        )
    if floats and encoding is None and array.min() >= 0 and array.max() <= 1:
        log.warning(
            '%s: floats from 0 to 1 are taken as scene-linear light: encoding="sRGB" takes them as screens show them, '
            'and encoding="linear" says that linear is meant',
            caller,
        )
    native = array.dtype.newbyteorder("=")
    return array, ArrayKind(native, encoding or ("linear" if floats else "sRGB"))


def _array(rgb: Any) -> npt.NDArray[Any]:
    """Return a picture's numbers as an array; raise ArgumentError for what is no picture."""
    mode = getattr(rgb, "mode", None)
    if isinstance(mode, str) and hasattr(rgb, "convert") and mode not in _PILLOW_MODES:
        hint = f"rgb.convert({'RGBA' if 'A' in mode.upper() else 'RGB'!r})"
        raise ArgumentError(f"rgb: found a Pillow image of mode {mode!r}", hint=hint, parameter="rgb")
    if isinstance(rgb, oiio.ImageBuf):
        spec = rgb.spec()
        pixels = rgb.get_pixels(spec.format) if spec.nchannels and not spec.deep else None
        if pixels is None:
            raise ArgumentError("rgb: expected an ImageBuf with flat pixels", parameter="rgb")
        return np.asarray(pixels)
    try:
        return np.asarray(rgb)
    except (TypeError, ValueError, RuntimeError) as error:  # a ragged list, a tensor on a graphics card
        raise ArgumentError(f"rgb: NumPy cannot read it: {error}", code="wrong-type", parameter="rgb") from error


def _check_shape(array: npt.NDArray[Any]) -> None:
    """Raise ArgumentError unless an array is (H, W), (H, W, 1), (H, W, 3) or (H, W, 4), and not empty."""
    if array.size and (array.ndim == 2 or (array.ndim == 3 and array.shape[2] in (1, 3, 4))):
        return
    hint = ""
    if array.ndim == 3 and array.shape[0] in (1, 3, 4):
        hint = "channels come last: np.moveaxis(rgb, 0, -1)"
    elif array.ndim == 4:
        hint = "one picture at a time"
    raise ArgumentError(
        f"rgb: expected (H, W), (H, W, 3) or (H, W, 4), found {array.shape}", hint=hint, parameter="rgb"
    )
