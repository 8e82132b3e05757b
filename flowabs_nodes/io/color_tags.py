"""Say in the header of a PNG or TIFF what its colours are, and know what such a header can say."""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import color
from flowabs_nodes.color import ocio as named_spaces
from flowabs_nodes.color.config import Config
from flowabs_nodes.color.encoding import Encoding
from flowabs_nodes.color.icc import with_profile
from flowabs_nodes.color.named import find
from flowabs_nodes.color.spaces import KNOWN, convert
from flowabs_nodes.color.transfers import Sampled
from flowabs_nodes.errors import ColorError
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.oiio_error import reason
from flowabs_nodes.io.private_folder import is_full, no_space_in, private_folder

SRGB = "srgb_rec709_scene"

#: Codes whose colours tell two encodings apart.
_PROBES = np.array([[[0.1, 0.1, 0.1], [0.5, 0.5, 0.5], [0.9, 0.1, 0.1], [0.2, 0.8, 0.1], [0.1, 0.3, 0.9]]], np.float32)


def tag(spec: oiio.ImageSpec, encoding: str | Encoding | None) -> None:
    """Put what an encoding is into a header for OpenImageIO to write; None says nothing."""
    if isinstance(encoding, Encoding):
        spec.attribute("oiio:ColorSpace", "unknown")  # else a PNG would also say sRGB
        if encoding.profile:
            set_profile(spec, encoding.profile)
        if encoding.cicp:
            spec.attribute("CICP", oiio.TypeDesc("int[4]"), encoding.cicp)
    elif encoding is not None:
        spec.attribute("oiio:ColorSpace", encoding)


def set_profile(spec: oiio.ImageSpec, profile: bytes) -> None:
    """Put an ICC profile into a header."""
    spec.attribute("ICCProfile", oiio.TypeDesc(f"uint8[{len(profile)}]"), np.frombuffer(profile, np.uint8))


@cache
def says(format: Format, data_type: str, encoding: str | Encoding, ocio: Config | None = None) -> bool:
    """Return whether a file of this format and data type, read again, would be taken for this encoding.

    A picture of one pixel is written to see it: what OpenImageIO can write differs from version to version. Others do
    not read the file with the config ``ocio`` in which the encoding has its name, so neither is it read here with it.
    Raises WriteError where no such picture can be written for want of space.
    """
    if isinstance(encoding, str) and data_type != "float" and find(encoding, ocio).kind == "srgb":
        return True
    spec = oiio.ImageSpec(1, 1, 3, data_type)
    tag(spec, encoding)
    with private_folder() as folder:
        path = os.path.join(folder, "probe" + format.extensions[0])
        output = oiio.ImageOutput.create(format.oiio_name)
        if output is None or not output.open(path, spec):
            reason(output or oiio)
            return _unless_full(path)
        output.write_image(np.zeros((1, 1, 3), np.float32))
        output.close()
        source = oiio.ImageInput.open(path)
        if source is None:
            reason(oiio)
            return _unless_full(path)
        found = color.detect(source.spec(), display_referred=data_type != "float")
        source.close()
    read = _decoded(found.encoding or found.space.name, None)
    return np.allclose(read, _decoded(encoding, ocio), rtol=0.01, atol=1e-3)


def _unless_full(path: str) -> bool:
    """Return False; raise WriteError where the file could not be written for want of space, which says nothing."""
    if is_full(path):
        raise no_space_in(os.path.dirname(os.path.dirname(path)))
    return False


@cache
def misread(name: str, ocio: Config) -> bool:
    """Return whether others, who do not have the config, take the name of one of its spaces for another space.

    It is not so for a name that means nothing to them.
    """
    if not ocio.content:
        return False
    try:
        theirs, ours = _decoded(name, None), _decoded(name, ocio)
    except ColorError as error:
        if error.code == "bad-ocio-config":
            raise
        return False
    return not np.allclose(theirs, ours, rtol=0.01, atol=1e-3)


@cache
def sayable(
    format: Format, data_type: str, encoding: str | Encoding, ocio: Config | None = None
) -> str | Encoding | None:
    """Return the same encoding in a way that a file of this format can say: as it is, or by a profile made for it.

    None where a file cannot say it at all, as the log of a camera.
    """
    if says(format, data_type, encoding, ocio):
        return encoding
    own = with_profile(_as_encoding(encoding, ocio))
    if own is None or not np.allclose(_decoded(own, ocio), _decoded(encoding, ocio), rtol=0.01, atol=1e-3):
        return None
    return own if says(format, data_type, own, ocio) else None


def _as_encoding(encoding: str | Encoding, ocio: Config | None) -> Encoding:
    """Return an OCIO name's primaries and the curve of its neutrals, which may not be all that there is to it."""
    if isinstance(encoding, Encoding):
        return encoding
    neutrals = np.repeat(np.linspace(0, 1, 4096, dtype=np.float32)[None, :, None], 3, axis=2)
    linear, space = named_spaces.linearize(neutrals, encoding, ocio)
    curve = Sampled(tuple(linear[0, :, 1].tolist()))
    return Encoding(encoding, space, (curve, curve, curve))


def _decoded(encoding: str | Encoding, ocio: Config | None) -> np.ndarray:
    """Return the colours of the probes in one space."""
    rgb, space = named_spaces.linearize(_PROBES, encoding, ocio)
    return convert(rgb, space, KNOWN["lin_ap0_scene"])
