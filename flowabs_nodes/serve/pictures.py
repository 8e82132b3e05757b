"""Pictures of hosts in requests: where the pixels lie, how, and what they mean; to images, and images to them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.errors import CommandError
from flowabs_nodes.file_choices import ROWS
from flowabs_nodes.image import Image, Window
from flowabs_nodes.port_types import TYPES, pixel_type
from flowabs_nodes.serve.fields import Fields
from flowabs_nodes.serve.shared_memory import SharedMemory

CHANNELS = ("RGBA", "RGB", "A")
DATA_TYPES = ("float32", "float16", "uint8", "uint16")
ALPHAS = ("premultiplied", "straight", "opaque")
_PLACE = ("memory", "offset", "width", "height", "channels", "dtype", "row_bytes", "rows")
_MEANING = ("colorspace", "alpha", "window", "display", "content")

_MOST = 2**31 - 1  # of a width, a height


@dataclass(frozen=True)
class Picture:
    """Where a host's pixels lie, how, and what they mean: PICTURE of docs/serve.md.

    ``content`` is the client's name for these very pixels, "" is none: with one name they are the same, bit for bit.
    ``memory`` None is the message's payload. ``width`` and ``height`` None, only where a picture is to be written, are
    those of the result. ``row_bytes`` 0 are rows without gaps.
    """

    memory: SharedMemory | None
    number: int | None
    offset: int | None
    width: int | None
    height: int | None
    channels: str
    dtype: np.dtype[Any]
    row_bytes: int
    rows: str
    colorspace: str
    alpha: str
    window: tuple[int, int]
    display: tuple[int, ...] | None
    content: str = ""

    # ------------------------------------------------------------------ layout

    @property
    def sized(self) -> tuple[int, int]:
        """Return height and width."""
        if self.height is None or self.width is None:
            raise ValueError("a picture whose size is the result's")
        return self.height, self.width

    @property
    def step(self) -> int:
        """Return the bytes from one row to the next in the host's order; negative where they go down in memory."""
        return self.row_bytes or self.sized[1] * len(self.channels) * self.dtype.itemsize

    @property
    def payload_bytes(self) -> int:
        """Return how many bytes of the message's payload are this picture's."""
        return 0 if self.memory is not None else self.sized[0] * abs(self.step)

    def view(self, payload: npt.NDArray[np.uint8] | None = None) -> npt.NDArray[Any]:
        """Return the pixels (H, W, C) in the host's order of rows: a view of the memory, or of ``payload``.

        Raises CommandError where they do not lie within it.
        """
        (height, width), step = self.sized, self.step
        buffer: Any = payload if self.memory is None else self.memory.view
        size = len(buffer) if self.memory is None else self.memory.bytes
        row = width * len(self.channels) * self.dtype.itemsize
        first = self.offset
        if first is None:
            first = (height - 1) * -step if step < 0 else 0
        lowest, last = first + min(0, (height - 1) * step), first + max(0, (height - 1) * step)
        if lowest < 0 or last + row > size:
            found = f"{width}x{height} from byte {lowest} to {last + row}"
            raise CommandError(
                f"picture: expected pixels within {size} bytes, found {found}",
                code="bad-picture",
                parameter="offset",
            )
        if self.memory is not None:
            self.memory.check()
        shape = (height, width, len(self.channels))
        return np.ndarray(
            shape, self.dtype, buffer, first, (step, len(self.channels) * self.dtype.itemsize, self.dtype.itemsize)
        )

    # ------------------------------------------------------------------ to an image

    def image(self, types: str, payload: npt.NDArray[np.uint8] | None = None) -> Image:
        """Return the image of the pixels, which are copied once, for an output whose port has these ``types``.

        Raises FlowabsError for pixels that are no such image.
        """
        pixels = self.view(payload)
        data_window = (*self.window, *reversed(self.sized))
        kind = self._type(types)
        said: tuple[str | None, ...]
        if kind == "color":
            channels = "RGBX" if (self.channels, self.alpha) == ("RGBA", "opaque") else self.channels
            said = self.colorspace, None, self._alpha, channels
        else:  # "linear", so that whole numbers are 0 to 1
            said = None, "linear" if pixel_type(kind).shown else None, None, None
        colorspace, encoding, alpha, channels_ = said
        return Image.from_array(
            pixels,
            colorspace,
            encoding=encoding,
            alpha=alpha,
            rows=self.rows,
            type=kind,
            channels=channels_,
            data_window=data_window,
            display_window=self.display,
        )

    @property
    def _alpha(self) -> str:
        """Return how colours stand to alpha; where there is none it does not matter."""
        return "premultiplied" if self.alpha == "opaque" else self.alpha

    def _type(self, types: str) -> str:
        """Return the type of the image for a port: that of the port if the channels fit, else a matte or a color."""
        declared = TYPES.get(types)
        fits = declared is not None and declared.channel_names(len(self.channels)) is not None
        if self.channels == "A":
            return types if fits else "matte"
        return types if fits and declared is not None and not declared.shown else "color"

    # ------------------------------------------------------------------ from an image

    def fill(self, image: Image) -> tuple[dict[str, Any], npt.NDArray[np.uint8] | None]:
        """Write an image, or the part of it that is asked for, into the host's memory.

        Returns
        -------
        What was written, as JSON, and the bytes to send where the memory is the answer's payload.
        """
        x, y, width, height = image.data_window
        if self.width is None or self.height is None:
            target = Picture(**{**vars(self), "width": width, "height": height, "window": (x, y)})
            return target.fill(image)
        (x, y), (height, width) = self.window, self.sized
        part = image.on_window(Window(x, y, width, height))
        bytes_ = np.empty(self.payload_bytes, np.uint8) if self.memory is None else None
        pixels = self.view(bytes_)
        declared, channels = pixel_type(image.type), None
        if declared.shown and not (self.channels == "A" and len(image.channels) == 1):
            channels = "RGBX" if (self.channels, self.alpha) == ("RGBA", "opaque") else self.channels
        part.to_array(
            out=pixels,
            colorspace=self.colorspace,
            alpha=self._alpha,
            rows=self.rows,
            channels=channels,
        )
        return self._said(image), bytes_

    def _said(self, image: Image) -> dict[str, Any]:
        """Return what was written, as a request would say it."""
        return {
            "memory": self.number,
            "offset": self.offset if self.memory is not None else None,
            "width": self.width,
            "height": self.height,
            "channels": self.channels,
            "dtype": self.dtype.name,
            "row_bytes": self.step,
            "rows": self.rows,
            "colorspace": self.colorspace,
            "alpha": self.alpha,
            "window": list(self.window),
            "display": list(image.display_window),
        }


def picture(
    values: Any, place: str, memories: Mapping[int, SharedMemory], max_pixels: int, *, sized: bool = True
) -> Picture:
    """Return the picture that JSON describes, at a ``place`` of a request: "given.plate".

    Unless it is to be ``sized``, width and height may be missing. Raises CommandError for what is missing or wrong.
    """
    found = Fields(values, place, (*_PLACE, *_MEANING))
    number = found.get("memory", int, None)
    if number is not None and number not in memories:
        raise CommandError(
            f"{place}.memory: no memory {number} is mapped", code="unknown-memory", parameter=f"{place}.memory"
        )
    channels = found.word("channels", CHANNELS, "RGBA")
    dtype = np.dtype(found.word("dtype", DATA_TYPES, "float32"))
    free = None if sized or found.values.get("width") or found.values.get("height") else 0
    height, width = (found.count(key, 1, _MOST) if free is None else None for key in ("height", "width"))
    row_bytes = found.get("row_bytes", int, 0)
    if width is not None and height is not None:
        if width * height > max_pixels:
            raise CommandError(
                f"{place}: {width}x{height} is more than {max_pixels} pixels",
                code="too-big",
                hint="--max-pixels allows more",
                parameter=place,
            )
        row = width * len(channels) * dtype.itemsize
        if row_bytes and not row <= abs(row_bytes) <= 2**48:
            raise CommandError(
                f"{place}.row_bytes: expected at least {row}, found {row_bytes}", code="bad-request", parameter=place
            )
    elif row_bytes:
        raise CommandError(f"{place}.row_bytes: expected with width and height", code="bad-request", parameter=place)
    memory = None if number is None else memories[number]
    x, y = found.numbers("window", 2) or (0, 0)
    most = math.inf if memory is None else memory.bytes
    return Picture(
        memory=memory,
        number=number,
        offset=found.count("offset", 0, int(min(most, 2**62)), None),  # type: ignore[arg-type]  # None: none is said
        width=width,
        height=height,
        channels=channels,
        dtype=dtype,
        row_bytes=row_bytes,
        rows=found.word("rows", ROWS, "top-down"),
        colorspace=found.get("colorspace", str, "lin_rec709"),
        alpha=found.word("alpha", ALPHAS, "premultiplied"),
        window=(x, y),
        display=found.numbers("display", 4),
        content=found.get("content", str, ""),
    )
