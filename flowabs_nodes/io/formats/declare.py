"""Declare a file format: all that the rest of the package asks about one is a field here."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

if TYPE_CHECKING:  # help texts list the formats: no reader or writer is imported for that
    import numpy.typing as npt
    import OpenImageIO as oiio


class Declared(NamedTuple):
    """The colour space that a header declares: a name that ``read.colorspace`` takes, and for the log its source."""

    name: str
    source: str


def _all_is_read(path: str) -> None:
    """Trust OpenImageIO with every file."""


def _all_is_in_the_header(path: str, spec: oiio.ImageSpec) -> None:
    """Trust OpenImageIO with every header."""


def _openimageio_reads(specs: Sequence[oiio.ImageSpec], problem: str) -> str:
    """Leave every file to OpenImageIO."""
    return ""


@dataclass(frozen=True)
class Format:
    """A file format: how its files are recognised, what they can hold, and who writes them.

    Functions are named as "module:function" and imported when they are first needed: reading a PNG imports no EXR
    encoder.

    Attributes
    ----------
    name, article
        How people call it, and the article before the name: "an" EXR, "a" PNG.
    oiio_name
        How OpenImageIO calls it; a file that OpenImageIO takes for something else is refused.
    extensions
        The ends of file names, in lower case, with the dot. OpenImageIO writes to a file with the first one.
    magic
        The first bytes of its files, one entry for each variant.
    help
        A sentence about it for the page of the node `read`, where more needs to be said than its name.

    Reading:

    display_referred
        True for pictures made to be looked at: whole numbers are sRGB unless the header says otherwise. Such a picture
        written into such a format keeps its encoding.
    declared
        Returns the colour space that a header declares in the format's own fields. None: the header has no such
        fields, and OpenImageIO's common tags say it (:func:`flowabs_nodes.color.detect`).
    alpha
        "premultiplied" and "straight" colour; "tagged": the header says which.
    oriented
        True where the header says which way is up, and pixels may lie on their side.
    integers
        "normalized": whole numbers are read as 0..1; "exact": 32-bit whole numbers are ids, and keep their value.
    reader
        Given the headers that OpenImageIO could read and its complaint, returns who opens the file instead, as
        "module:class" called with (path, place, format, settings), ``place`` another path by which it is opened; ""
        leaves the file to OpenImageIO.
    look
        Given the path of a file that begins as one of this format, raises ReadError where opening it would take much
        time or memory for nothing.
    check
        Given the path of a file that OpenImageIO could open, raises ReadError where OpenImageIO would read wrong pixels
        without a complaint.
    decoder
        "module:function", a :data:`Decoder`, of a format that compresses a part's channels together, so that several
        readers should not each decode them; "" where whoever reads a channel decodes no other.
    complete
        Given the path and the header of such a file, adds to the header what OpenImageIO leaves out.

    Writing:

    encoder
        "module:function" that returns a file's bytes, an :data:`Encoder`; "" for a format that is only read.
    data_types
        What it can hold of ``write.data_type``; "auto" takes the first one where the plate's does not fit.
    compression
        What OpenImageIO is asked for; "" is the format's own default.
    layers
        True where a file holds any number of layers and parts.
    hashed
        What the hash of a file's pixels is made of (:mod:`flowabs_nodes.io.pixel_hash`): of the "decoded" values, or of
        the bytes as they are "stored".
    stamps
        Where key and graph of a run are stored: in "attributes" of their own, or as lines of the "description" where
        the format drops attributes that it does not know.
    storage
        Attributes that describe how its files store pixels, by name or beginning: never carried to another file.
    """

    name: str
    oiio_name: str
    extensions: tuple[str, ...]
    magic: tuple[bytes, ...]
    article: str = "a"
    help: str = ""

    display_referred: bool = False
    declared: Callable[[oiio.ImageSpec], Declared] | None = None
    alpha: Literal["premultiplied", "straight", "tagged"] = "premultiplied"
    oriented: bool = True
    integers: Literal["normalized", "exact"] = "normalized"
    reader: Callable[[Sequence[oiio.ImageSpec], str], str] = _openimageio_reads
    look: Callable[[str], None] = _all_is_read
    check: Callable[[str], None] = _all_is_read
    complete: Callable[[str, oiio.ImageSpec], None] = _all_is_in_the_header

    decoder: str = ""
    encoder: str = ""
    data_types: tuple[str, ...] = ()
    compression: str = ""
    layers: bool = False
    hashed: Literal["decoded", "stored"] = "decoded"
    stamps: Literal["attributes", "description"] = "attributes"
    storage: tuple[str, ...] = ()

    @property
    def writable(self) -> bool:
        """True where frames can be written in it."""
        return bool(self.encoder)

    def stores_straight(self, spec: oiio.ImageSpec) -> bool:
        """Return True if the colour of a file with this header is not multiplied by its alpha."""
        tagged = self.alpha == "tagged" and spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 1
        return self.alpha == "straight" or tagged


#: The planes (H, W) of channels by name, in a file's own data types.
Planes = dict[str, "npt.NDArray[Any]"]

#: Called with (path, header, names of channels): returns their planes, or none where somebody else must read the file.
Decoder = Callable[[str, "oiio.ImageSpec", Sequence[str]], Planes]

#: Called with (picture, format, stamps, warn): returns the file's bytes. ``stamps`` are attributes of the run to store
#: where ``format.stamps`` says, ``warn`` is told what the format cannot hold. Raises WriteError.
Encoder = Callable[[Any, Format, Mapping[str, str], Callable[[str], None]], bytes]


def load(reference: str) -> Any:
    """Import what "module:name" refers to."""
    module, _, name = reference.partition(":")
    return getattr(importlib.import_module(module), name)
