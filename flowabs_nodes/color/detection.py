"""Detect the colour space of a file: from a parameter, tags, an ICC profile, chromaticities, else linear Rec.709."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes.color.chromaticities import space_from_chromaticities
from flowabs_nodes.color.cicp import read_cicp
from flowabs_nodes.color.config import Ocio, opened
from flowabs_nodes.color.encoding import Encoding, Transfer
from flowabs_nodes.color.icc import read_profile
from flowabs_nodes.color.lookup import space
from flowabs_nodes.color.named import SRGB_NAMES, find
from flowabs_nodes.color.spaces import KNOWN, ColorSpace
from flowabs_nodes.color.transfers import SRGB, Power
from flowabs_nodes.errors import ColorError

_SRGB = "srgb_rec709_scene"

#: Attributes, by name or beginning, that say what colours pixels are.
_COLOR_TAGS = (
    "CICP",
    "Exif:ColorSpace",
    "ICCProfile",
    "acesImageContainerFlag",
    "adoptedNeutral",
    "chromaticities",
    "colorInteropID",
    "oiio:ColorSpace",
    "oiio:Gamma",
)

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
        The encoding of the file's pixels, which :func:`flowabs_nodes.color.ocio.linearize` decodes: its OCIO name, or
        what the file's own profile, code points or chromaticities say; None where they are scene-linear already.
    """

    space: ColorSpace
    how: str
    encoding: str | Encoding | None = None


def detect(
    spec: oiio.ImageSpec,
    given: ColorSpace | str = "auto",
    ocio: Ocio = None,
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
        ocio = opened(ocio)
    fallback = space(default, ocio)
    if isinstance(given, ColorSpace):
        return Detected(given, f"{said_by}: {given}")
    if given and given != "auto":
        return _named(given, said_by, fallback, ocio)

    passed_over: list[str] = []
    found = _tagged(spec, ("colorInteropID",), fallback, ocio, passed_over)
    found = found or _described(spec, display_referred, passed_over)
    found = found or _tagged(spec, ("oiio:ColorSpace",), fallback, ocio, passed_over)
    found = found or _from_chromaticities(spec, display_referred, passed_over)
    if found is None and display_referred:
        found = Detected(space("lin_rec709"), "no tag in the file: sRGB", _SRGB)
    found = found or Detected(fallback, f"no tag in the file: {fallback}")
    return found._replace(how="; ".join([found.how, *passed_over]))


def without_stale(spec: oiio.ImageSpec) -> oiio.ImageSpec:
    """Return the header of a buffer that is no file any more, without what its ``oiio:ColorSpace`` has overtaken.

    OpenImageIO's colorconvert sets this tag, and leaves the profile and the other tags of the file that the pixels came
    from. An sRGB tag says nothing: OpenImageIO gives it to nearly every PNG that it reads, beside a profile too.
    """
    name = _text(spec, "oiio:ColorSpace")
    invented = _OIIO_INVENTS_TAGS and name == "lin_rec709"
    if not name or name.lower() in SRGB_NAMES | {"unknown"} or invented:
        return spec
    kept = oiio.ImageSpec(spec)
    forget(kept)
    kept.attribute("oiio:ColorSpace", name)
    return kept


def forget(spec: oiio.ImageSpec) -> None:
    """Remove from a header whatever :func:`detect` asks, and what else would only be true of these colours."""
    for name in [attribute.name for attribute in spec.extra_attribs]:
        if name.startswith(_COLOR_TAGS):
            spec.erase_attribute(name)


def _tagged(
    spec: oiio.ImageSpec, tags: tuple[str, ...], fallback: ColorSpace, ocio: Ocio, passed_over: list[str]
) -> Detected | None:
    """Return what the first of these tags says that means something; the others are ``passed_over``, for the log."""
    for tag in tags:
        name = _text(spec, tag)
        invented = _OIIO_INVENTS_TAGS and (tag, name) == ("oiio:ColorSpace", "lin_rec709")
        if not name or name.lower() == "unknown" or invented:
            continue
        try:
            return _named(name, tag, fallback, ocio)
        except ColorError as error:
            if error.code in ("bad-ocio-config", "no-interchange", "bad-conversion"):
                raise
            passed_over.append(f"{tag} {name[:60]!r} means nothing here")
    return None


def _described(spec: oiio.ImageSpec, display_referred: bool, passed_over: list[str]) -> Detected | None:
    """Return what the file's own description says: code points (CICP), which go before an ICC profile (PNG)."""
    codes = spec.getattribute("CICP")
    if codes is not None:
        try:
            return _encoded(read_cicp(np.ravel(codes).tolist()), display_referred)
        except (ColorError, ValueError) as error:
            reason = error.message if isinstance(error, ColorError) else "damaged"
            passed_over.append(f"its cICP {tuple(np.ravel(codes).tolist())} is not used: {reason}")
    profile = spec.getattribute("ICCProfile")
    if profile is not None and not isinstance(profile, str | int | float):  # of which an EXR may have one of that name
        name = _text(spec, "ICCProfile:profile_description")[:60]
        try:
            return _encoded(read_profile(np.asarray(profile, np.uint8).tobytes(), name), display_referred)
        except ColorError as error:
            passed_over.append(f"its ICC profile {name!r} is not used: {error.message}")
    return None


def _from_chromaticities(spec: oiio.ImageSpec, display_referred: bool, passed_over: list[str]) -> Detected | None:
    """Return the space of the header's chromaticities; of a photograph, encoded by its gamma or else as sRGB is."""
    values = spec.getattribute("chromaticities")
    if values is None:
        return None
    try:
        primaries = space_from_chromaticities(*np.reshape(values, (4, 2)))
    except (ColorError, ValueError):
        passed_over.append("its chromaticities are no colour space")
        return None
    if not display_referred:
        return Detected(primaries, f"chromaticities: {primaries}")
    gamma = spec.get_float_attribute("oiio:Gamma", 0.0)
    transfer: Transfer = Power(round(gamma, 4)) if 0 < gamma < 10 else SRGB
    name = f"chromaticities {primaries}, {f'gamma {gamma:.4g}' if transfer is not SRGB else 'sRGB curve'}"
    return _encoded(Encoding(name, primaries, (transfer, transfer, transfer)), display_referred)


def _encoded(found: Encoding, display_referred: bool) -> Detected:
    """Return what an encoding means: sRGB by its name where it is that; of a float file, linear where it is linear."""
    if found.space == KNOWN["lin_rec709"] and found.like(SRGB, 1e-3):
        return Detected(found.space, f"{found.name}: sRGB", _SRGB)
    if found.like(Power(1.0), 1e-6) and not display_referred:
        return Detected(found.space, f"{found.name}: {found.space}")
    return Detected(found.space, f"{found.name}, brought to {found.space}", found)


def _named(name: str, source: str, fallback: ColorSpace, ocio: Ocio) -> Detected:
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
