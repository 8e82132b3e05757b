"""Tell what the numbers of a host's picture mean.

They may be whole numbers or floats, scene-linear or encoded (sRGB, a log), premultiplied or straight.
"""

from __future__ import annotations

from dataclasses import dataclass

from flowabs_nodes import color
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.spaces import ColorSpace, known
from flowabs_nodes.errors import ArgumentError, FlowabsError, nearest
from flowabs_nodes.file_choices import HOST_ALPHAS


@dataclass(frozen=True)
class Numbers:
    """The meaning of the numbers of a picture's colours.

    Attributes
    ----------
    space
        The scene-linear space of the numbers, once they are decoded.
    encoding
        What they are decoded from; None where they are scene-linear.
    straight
        Whether colours are not multiplied by alpha.
    scaled
        Whether whole numbers stand for 0..1: somebody said what they mean.
    kept
        The scene-linear space that an image of them is kept in.
    """

    space: ColorSpace
    encoding: str | Encoding | None
    straight: bool
    scaled: bool
    kept: ColorSpace

    @property
    def plain(self) -> bool:
        """Return whether the numbers are those of an image in ``space``: scene-linear and premultiplied."""
        return self.encoding is None and not self.straight


def meaning(
    colorspace: ColorSpace | str | None,
    encoding: str | None,
    alpha: str | None,
    *,
    floats: bool,
    default: ColorSpace | str = "lin_rec709",
) -> Numbers:
    """Return what numbers mean, of which people say ``colorspace``, ``encoding`` and ``alpha``.

    Parameters
    ----------
    colorspace
        A scene-linear space: that of the numbers, or with an ``encoding`` that of the image. Without an ``encoding``
        the name of an encoding will do: numbers are then decoded to the space with its primaries. None is ``default``.
    encoding
        The name of any colour space; "linear" for numbers that are scene-linear in ``colorspace``. None: as
        ``colorspace`` says.
    alpha
        "premultiplied", "straight", or None: premultiplied in scene-linear ``floats``, else straight.

    Raises ArgumentError and ColorError, with the nearest names.
    """
    if encoding is not None and (not isinstance(encoding, str) or not encoding):
        raise ArgumentError(
            f'encoding: expected a name such as "sRGB" or "linear", found {encoding!r}',
            code="wrong-type",
            parameter="encoding",
        )
    if alpha is not None and alpha not in HOST_ALPHAS:
        raise ArgumentError(
            f"alpha: expected {' or '.join(map(repr, HOST_ALPHAS))}, found {alpha!r}",
            hint=nearest(alpha, HOST_ALPHAS),
            parameter="alpha",
        )
    linear = encoding is not None and encoding.lower() == "linear"
    source = default if colorspace is None else colorspace
    said_by = "colorspace"
    if encoding is not None and not linear:
        source, said_by = encoding, "encoding"
    target = colorspace if encoding is not None else None
    try:
        decode = None if linear else encoded_as(source)
        space = color.space(source) if decode is None else _primaries(decode)
        said_by = "colorspace"
        kept = space if target is None else color.space(target)
    except FlowabsError as error:
        error.parameter = error.parameter or said_by
        raise
    straight = alpha == "straight" if alpha is not None else decode is not None or not floats
    return Numbers(space, decode, straight, encoding is not None or decode is not None, kept)


def encoded_as(colorspace: ColorSpace | str) -> str | None:
    """Return the name of code values, such as sRGB; None for that of a scene-linear space, and for data."""
    if not isinstance(colorspace, str) or not colorspace or known(colorspace) is not None:
        return None
    from flowabs_nodes.color import named  # imports OpenColorIO, which known spaces do not need

    return colorspace if named.find(colorspace).kind not in ("linear", "data") else None


def _primaries(encoding: str) -> ColorSpace:
    """Return the scene-linear space that an encoding is decoded to."""
    from flowabs_nodes.color import named

    return named.find(encoding).space
