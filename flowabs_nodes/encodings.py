"""What is computed from images in one evaluation of a graph, each thing once: code values, decoded pixels, alpha.

An image is a value and keeps nothing of the kind. :meth:`Image.encoded <flowabs_nodes.image.Image.encoded>` and its
neighbours ask the :class:`Encodings` of the evaluation that they are called in, which belong to the engine: it says
which code values later nodes will ask for, and which image is asked for the last time. Outside of
:func:`remember_encodings` every call computes afresh.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.simd.read_only import read_only

if TYPE_CHECKING:
    from flowabs_nodes.image import Image

#: An encoding, "lab" or "acescct", and the ground behind the picture; None for the colours of rgb / A.
Encoding = tuple[str, float | None]

_AT_ONCE = 2**17  # pixels that are decoded at once where the picture as a whole never is


@dataclass
class _Made:
    """What has been computed from one image."""

    expected: frozenset[str] = frozenset()
    kept: bool = True
    codes: dict[Encoding, Array] = field(default_factory=dict)
    lightness: dict[Encoding, Array] = field(default_factory=dict)
    pixels: Array | None = None
    alpha: Array | None = None
    alpha_known: bool = False


class Encodings:
    """Code values, decoded pixels and alpha of images, all read-only; those of an image are freed with it."""

    def __init__(self) -> None:
        self._made: WeakKeyDictionary[Image, _Made] = WeakKeyDictionary()
        #: What an image's pixels are decoded inside of: the engine takes the time.
        self.decoding: Callable[[Image], AbstractContextManager[None]] = lambda image: nullcontext()

    # ------------------------------------------------------------------ what the engine says

    def expect(self, image: Image, spaces: frozenset[str]) -> None:
        """Keep what is computed from ``image``; after its lightness, its codes in ``spaces`` will be asked for.

        Both are then made together, in one pass.
        """
        made = self._of(image)
        made.expected, made.kept = made.expected | spaces, True

    def keep(self, image: Image, kept: bool) -> None:
        """Say whether the code values of ``image`` are kept; if not, whoever asks for them next alone holds them."""
        self._of(image).kept = kept

    # ------------------------------------------------------------------ what images ask for

    def pixels(self, image: Image) -> Array:
        """Return the pixels of an image, decoded where a filter left code values."""
        if image.deferred is None:
            return image.pixels
        made = self._of(image)
        if made.pixels is None:
            with self.decoding(image):
                decoded, shape = image.deferred.decode(image.colorspace), image.deferred.shape
            if decoded.dtype != np.float32 or decoded.shape != shape:
                message = f"pixels were decoded as {decoded.dtype} {decoded.shape}, expected float32 {shape}"
                raise FlowabsError(message, code="wrong-type")
            made.pixels = read_only(decoded)
        return made.pixels

    def let_go(self, image: Image) -> None:
        """Forget the decoded pixels of an image, unless they are kept: whoever has used them needs them no more."""
        if image in self._made and not self._made[image].kept:
            self._made[image].pixels = None

    def alpha(self, image: Image) -> Array | None:
        """Return the coverage (H, W) of an image; None where it is opaque: no A, or A = 1 in every pixel."""
        made = self._of(image)
        if not made.alpha_known:
            if "A" in image.channels and image.type == "color":
                under = image.pixels if image.deferred is None else image.deferred.codes.under
                assert under is not None
                alpha = np.ascontiguousarray(under[..., 3])
                made.alpha = None if bool((alpha == 1).all()) else read_only(alpha)
            made.alpha_known = True
        return made.alpha

    def share_alpha(self, image: Image, parent: Image) -> None:
        """Let an image that has the alpha of ``parent`` know what is known of that."""
        if parent in self._made:
            made, known = self._of(image), self._made[parent]
            made.alpha, made.alpha_known = known.alpha, known.alpha_known

    def codes(self, image: Image, space: str, ground: float | None) -> Array:
        """Return the code values (H, W, 3) of a color image; of an opaque one the ``ground`` does not matter."""
        made, encoding = self._of(image), (space, self._ground(image, ground))
        own = _own_codes(image, encoding)
        if own is not None:
            return own
        if encoding not in made.codes:
            self._encode(image, encoding, mono=False)
        return _handed_out(made, made.codes[encoding])

    def mono(self, image: Image, space: str, ground: float | None) -> Array:
        """Return the code values (H, W) of the lightness of a color image; ``ground`` is as in :meth:`codes`."""
        made, encoding = self._of(image), (space, self._ground(image, ground))
        if encoding not in made.lightness:
            own = _own_codes(image, encoding)
            if own is not None and space == "lab":
                made.lightness[encoding] = read_only(np.ascontiguousarray(own[..., 0]))
            else:
                self._encode(image, encoding, codes=encoding[1] is None and space in made.expected)
        return _handed_out(made, made.lightness[encoding])

    def opponent(self, image: Image, space: str, ground: float | None) -> Array:
        """Return lightness and two channels of colour (H, W, 3): L*, a*, b*, or in acescct red and blue less it."""
        from flowabs_nodes.color.codes import OPPONENT

        return self.codes(image, space if space == "lab" else OPPONENT, ground)

    def _ground(self, image: Image, ground: float | None) -> float | None:
        """Return the ground that shows behind an image: None behind an opaque one."""
        return None if ground is None or self.alpha(image) is None else ground

    def _encode(self, image: Image, encoding: Encoding, *, codes: bool = True, mono: bool = True) -> None:
        """Make and keep the code values of all channels, of the lightness, or both in one pass."""
        from flowabs_nodes.color.codes import BARE, encoded  # numba, which an image without code values does not need

        made, (space, ground) = self._of(image), encoding
        codes = codes and encoding not in made.codes
        encode = partial(
            encoded,
            space=space,
            colorspace=image.colorspace,
            ground=BARE if ground is None else ground,
            codes=codes,
            mono=mono,
        )
        if image.deferred is None or made.kept or made.pixels is not None:
            colors, lightness = encode(self.pixels(image))
        else:
            colors, lightness = self._encoded_in_bands(image, encode, codes, mono)
        if codes:
            made.codes[encoding] = read_only(colors)
        if mono:
            made.lightness[encoding] = read_only(lightness)
        self.let_go(image)

    def _encoded_in_bands(
        self, image: Image, encode: Callable[[Array], tuple[Array, Array]], codes: bool, mono: bool
    ) -> tuple[Array, Array]:
        """Return what ``encode`` makes of an image's pixels, of which there are never more than some rows at a time."""
        from flowabs_nodes.simd.bands import limited, over_rows
        from flowabs_nodes.simd.known_finite import mark_finite

        source = image.deferred
        assert source is not None
        height, width, _ = source.shape
        colors = np.empty((height, width, 3) if codes else (0, 0, 3), np.float32)
        lightness = np.empty((height, width) if mono else (0, 0), np.float32)

        def band(first: int, last: int) -> None:
            """Encode the rows ``first`` .. ``last`` - 1."""
            with limited(1):  # the bands are what threads share
                made, grey = encode(source.decode_rows(first, last, image.colorspace))
                if codes:
                    colors[first:last] = made
                if mono:
                    lightness[first:last] = grey

        try:
            with self.decoding(image):
                over_rows(band, height, most=max(1, _AT_ONCE // width))
        except ArgumentError:
            return encode(self.pixels(image))  # counts and places what is wrong in the whole picture
        return mark_finite(colors), mark_finite(lightness)

    def _of(self, image: Image) -> _Made:
        """Return what has been computed from an image."""
        return self._made.setdefault(image, _Made())


def _own_codes(image: Image, encoding: Encoding) -> Array | None:
    """Return the code values that the image's pixels are to be decoded from, if they are just these."""
    source = image.deferred
    plain = source is not None and source.codes is source
    return source.codes.values if source is not None and plain and (source.codes.space, None) == encoding else None


def _handed_out(made: _Made, codes: Array) -> Array:
    """Return ``codes``; forget all code values of the image unless they are kept."""
    if not made.kept:
        made.codes.clear()
        made.lightness.clear()
    return codes


_current: ContextVar[Encodings | None] = ContextVar("flowabs_encodings", default=None)


def current() -> Encodings:
    """Return the encodings of this evaluation; outside of one, new ones that nobody else will see."""
    return _current.get() or Encodings()


@contextmanager
def remember_encodings() -> Iterator[Encodings]:
    """Compute inside nothing twice that is kept: the images asked inside share these :class:`Encodings`."""
    encodings = Encodings()
    token = _current.set(encodings)
    try:
        yield encodings
    finally:
        _current.reset(token)
