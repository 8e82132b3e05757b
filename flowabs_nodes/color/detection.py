"""Detect the colour space of a file: from a parameter, a tag, chromaticities, else linear Rec.709."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.color.chromaticities import space_from_chromaticities
from flowabs_nodes.color.config import config
from flowabs_nodes.color.lookup import space
from flowabs_nodes.color.named import find
from flowabs_nodes.color.spaces import ColorSpace
from flowabs_nodes.errors import ColorError

#: Before 3.1, OpenImageIO tags nearly every EXR "lin_rec709", whatever its header says.
_OIIO_INVENTS_TAGS = oiio.VERSION < 30100


class Detected(NamedTuple):
    """The colour space of a file.

    Attributes
    ----------
    space
        The scene-linear space to work in.
    how
        Where the space was found, for the log: "chromaticities: lin_ap0_scene".
    encoding
        The OCIO name of the encoding of the file's pixels (:func:`flowabs_nodes.color.ocio.linearize`); None where they
        are scene-linear already.
    """

    space: ColorSpace
    how: str
    encoding: str | None = None


def detect(
    spec: oiio.ImageSpec,
    given: ColorSpace | str = "auto",
    ocio: str | None = None,
    default: ColorSpace | str = "lin_rec709",
    *,
    display_referred: bool = False,
    said_by: str = "given",
) -> Detected:
    """Return the colour space of a file with this header.

    Parameters
    ----------
    spec
        The header.
    given
        The space or OCIO name that a user gives, which then counts; "auto" asks the header.
    ocio
        The OCIO config that names are looked up in; None is the pinned one.
    default
        The scene-linear space of a file whose header names none.
    display_referred
        Whether the file format is one of photographs (PNG, JPEG, TIFF of whole numbers): sRGB unless the header names
        another space.
    said_by
        Who says ``given``, for ``how``: the header's own field, where a file format has one.

    Raises
    ------
    ColorError
        If ``given`` or ``default`` is no colour space, or the config cannot be read. Never for the contents of a
        header: a tag or chromaticities that mean nothing are passed over, and ``how`` says so.
    """
    if ocio is not None:
        config(ocio)
    fallback = space(default, ocio)
    if isinstance(given, ColorSpace):
        return Detected(given, f"{said_by}: {given}")
    if given and given != "auto":
        return _named(given, said_by, fallback, ocio)

    passed_over = []
    profile = _text(spec, "ICCProfile:profile_description")
    if display_referred and profile and "srgb" not in profile.lower():
        passed_over.append(f"its ICC profile {profile!r} is not used")
    tags = [(tag, _text(spec, tag)) for tag in ("colorInteropID", "oiio:ColorSpace")]
    if _OIIO_INVENTS_TAGS:
        tags = [(tag, name) for tag, name in tags if (tag, name) != ("oiio:ColorSpace", "lin_rec709")]
    for tag, name in tags:
        if not name or name.lower() == "unknown":
            continue
        try:
            found = _named(name, tag, fallback, ocio)
            return found._replace(how="; ".join([found.how, *passed_over]))
        except ColorError as error:
            if error.code == "bad-ocio-config":
                raise
            passed_over.append(f"{tag} {name[:60]!r} means nothing here")
    values = spec.getattribute("chromaticities")
    if values is not None:
        try:
            primaries = space_from_chromaticities(*np.reshape(values, (4, 2)))
            return Detected(primaries, "; ".join([f"chromaticities: {primaries}", *passed_over]))
        except (ColorError, ValueError):
            passed_over.append("its chromaticities are no colour space")
    if display_referred:
        return Detected(space("lin_rec709"), "; ".join(["no tag in the file: sRGB", *passed_over]), "srgb_rec709_scene")
    return Detected(fallback, "; ".join([f"no tag in the file: {fallback}", *passed_over]))


def _named(name: str, source: str, fallback: ColorSpace, ocio: str | None) -> Detected:
    """Return the space called ``name``, which was found in ``source`` (for the log); ``fallback`` for data."""
    found = find(name, ocio)
    if found.kind == "linear":
        return Detected(found.space, f"{source}: {name}")
    if found.kind == "data":
        return Detected(fallback, f"{source}: {name}, no colour: taken as {fallback}")
    return Detected(found.space, f"{source}: {name}, brought to {found.space}", name)


def _text(spec: oiio.ImageSpec, name: str) -> str:
    """Return a text attribute; "" where it is missing, no text, or no UTF-8."""
    try:
        value = spec.getattribute(name)
    except UnicodeDecodeError:
        return ""
    return value if isinstance(value, str) else ""
