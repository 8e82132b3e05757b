"""OCIO configs, by way of OpenImageIO's ColorConfig: open a config, look up its names, convert pixels with it.

The functions take a config as ``ocio``: a path, an "ocio://..." name, a :class:`Config` that is open already, or None
for the pinned one. None of them reads ``$OCIO``: the engine does, once for a run (engine/ocio_choice.py).
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import forks
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import config_files
from flowabs_nodes.color.constants import RGB_TO_XYZ
from flowabs_nodes.errors import ColorError, nearest

#: Built into OpenColorIO since 2.4 (OpenImageIO 3.0): the ACES spaces, the lin_* names of the Color Interop Forum,
#: cameras.
PINNED = "ocio://studio-config-v2.2.0_aces-v1.3_ocio-v2.4"

#: The roles that tie a config to all others: ACES2065-1, and CIE XYZ of D65 for what is display-referred.
ACES_ROLE, XYZ_ROLE = "aces_interchange", "cie_xyz_d65_interchange"

#: Spaces that tie a config to others all the same where it has no such role, as configs before OCIO 2: their names
#: there, and ours.
_WELL_KNOWN = (
    ("lin_ap0_scene", "lin_ap0_scene"),
    ("ACES2065-1", "lin_ap0_scene"),
    ("ACES - ACES2065-1", "lin_ap0_scene"),
    ("lin_ap1_scene", "lin_ap1_scene"),
    ("ACEScg", "lin_ap1_scene"),
    ("ACES - ACEScg", "lin_ap1_scene"),
    ("lin_rec709_scene", "lin_rec709"),
    ("lin_rec709", "lin_rec709"),
)


@dataclass(frozen=True)
class Config:
    """An OCIO config as it stood when it was opened: what is computed with it is cached by this value.

    Attributes
    ----------
    name
        What the user calls it: a path, or "ocio://...".
    path
        What OpenImageIO is given: ``name``, or a copy of that file (color/config_files.py).
    content
        "" for the pinned config, an "ocio://..." name, or a hash of the file and of all that it refers to.
    """

    name: str
    path: str
    content: str


Ocio = str | os.PathLike[str] | Config | None

_lock = threading.Lock()
forks.take_before(_lock)


def opened(ocio: Ocio = None) -> Config:
    """Return a config as it stands now. Raises ColorError where it is missing, unreadable or broken."""
    if isinstance(ocio, Config):
        return ocio
    ocio = os.fspath(ocio) if ocio else PINNED
    if ocio == PINNED:
        return Config(PINNED, PINNED, "")
    if ocio.startswith("ocio://"):
        found = Config(ocio, ocio, ocio)
    else:
        if not os.path.exists(ocio):
            raise unreadable(ocio, "no such file")
        if not os.path.isfile(ocio):
            raise unreadable(ocio, "not a file")
        try:
            content, path = config_files.edition(ocio)
        except (OSError, ValueError) as error:
            raise unreadable(ocio, getattr(error, "strerror", None) or str(error)) from error
        found = Config(ocio, path, content)
    with _lock:
        _parsed(found)
    return found


def config(ocio: Ocio = None) -> Any:
    """Return the ColorConfig, parsed once for each content.

    Raises ColorError where the config cannot be read: OpenImageIO itself would fall back to a dozen built-in spaces and
    only leave a message.
    """
    found = opened(ocio)
    with _lock:
        return _parsed(found)


@cache
def _parsed(opened: Config) -> Any:
    """Parse a config."""
    if oiio.VERSION < 30100 and config_files.is_archive(opened.path):  # it ends the process
        raise unreadable(opened.name, "OpenImageIO 3.0 reads no archives; 3.1 does")
    found = oiio.ColorConfig(opened.path)
    problem = said(found.geterror)
    if problem or found.configname() == "built-in":
        raise unreadable(opened.name, problem or "no reason given")
    return found


def unreadable(name: str, why: str) -> ColorError:
    """Return the error for a config that cannot be read."""
    return ColorError(
        f"the OCIO config {name!r} cannot be read: {why}",
        code="bad-ocio-config",
        hint=f"without one, {PINNED} is used",
    )


def has(name: str, ocio: Ocio = None) -> bool:
    """Return whether the config knows a name, alias or role, in any case."""
    found = opened(ocio)
    if found.content:
        return name.lower() in _declared(found)
    return bool(config(found).getColorSpaceIndex(name) >= 0)


def canonical(name: str, ocio: Ocio = None) -> str:
    """Return the config's own name for a space, alias or role."""
    found = opened(ocio)
    return _declared(found)[name.lower()] if found.content else str(config(found).resolve(name))


@cache
def _declared(opened: Config) -> dict[str, str]:
    """Return every name, alias and role that a config declares, in lower case, and the space that it stands for.

    OpenImageIO guesses more: that a space called sRGB is srgb_rec709_scene, or that one is ACEScg by another name.
    """
    found = config(opened)
    spaces = [str(space) for space in found.getColorSpaceNames()]
    meant = {str(role).lower(): str(found.getColorSpaceNameByRole(role)) for role in found.getRoles()}
    meant |= {str(alias).lower(): space for space in spaces for alias in found.getAliases(space)}
    return meant | {space.lower(): space for space in spaces}


def names(ocio: Ocio = None) -> list[str]:
    """Return every name, alias and role of the config, for hints."""
    found = config(ocio)
    spaces = [str(space) for space in found.getColorSpaceNames()]
    aliases = (str(alias) for space in spaces for alias in found.getAliases(space))
    return [*spaces, *aliases, *map(str, found.getRoles())]


def reference(ocio: Ocio = None) -> tuple[str, str]:
    """Return a scene-linear space through which the config is tied to others: its name there, and ours.

    It is the role "aces_interchange", or else a space whose name everybody knows. Raises ColorError where there is
    neither.
    """
    return _reference(opened(ocio))


@cache
def _reference(opened: Config) -> tuple[str, str]:
    """Find the space that :func:`reference` returns."""
    for theirs, ours in ((ACES_ROLE, "lin_ap0_scene"), *_WELL_KNOWN):
        if has(theirs, opened):
            return canonical(theirs, opened), ours
    raise ColorError(
        f"the OCIO config {opened.name!r} has no interchange role ({ACES_ROLE}), nor a space called ACES2065-1, ACEScg "
        "or lin_rec709, so its colours cannot be brought to others",
        code="no-interchange",
        hint=f"add to its roles {ACES_ROLE}: the name of its ACES2065-1",
    )


def is_data(name: str, ocio: Ocio = None) -> bool:
    """Return whether a config's own name is of data, which OCIO does not convert."""
    found = config(ocio)
    if hasattr(found, "isData"):
        return bool(found.isData(name))
    path = opened(ocio).path
    if os.path.isfile(path):  # OpenImageIO 3.0 does not tell
        return config_files.said_of_spaces(path, "isdata").get(name, "").lower() in ("true", "yes")
    theirs, _ = reference(ocio)  # of a built-in config: data is what no conversion changes
    probes = np.eye(3, dtype=np.float32)[None]
    return name != theirs and np.allclose(convert(probes, name, theirs, ocio), probes, atol=1e-6)


def to_known(pixels: Array, name: str, ocio: Ocio = None) -> tuple[Array, str]:
    """Convert (H, W, 3 or 4) pixels of a space of the config to one of our spaces, and return that one's name."""
    found = opened(ocio)
    if _by_xyz(name, found):
        return _through(np.linalg.inv(_REC709_TO_XYZ), convert(pixels, name, XYZ_ROLE, found)), "lin_rec709"
    theirs, ours = reference(found)
    return convert(pixels, name, theirs, found), ours


def from_known(pixels: Array, name: str, ocio: Ocio = None) -> Array:
    """Convert pixels of :func:`known_of` to a space of the config: the inverse of :func:`to_known`."""
    found = opened(ocio)
    if _by_xyz(name, found):
        return convert(_through(_REC709_TO_XYZ, pixels), XYZ_ROLE, name, found)
    return convert(pixels, reference(found)[0], name, found)


def known_of(name: str, ocio: Ocio = None) -> str:
    """Return the name of our space that a space of the config is converted to and from."""
    return "lin_rec709" if _by_xyz(name, opened(ocio)) else reference(ocio)[1]


#: Rec.709's white is D65, so that nothing is adapted on the way to CIE XYZ of D65.
_REC709_TO_XYZ = np.array(RGB_TO_XYZ["ITU-R BT.709"]).reshape(3, 3)


@cache
def _by_xyz(name: str, opened: Config) -> bool:
    """Return whether a space is tied to others by CIE XYZ: a display's, of a config without another interchange."""
    if not has(XYZ_ROLE, opened) or any(has(theirs, opened) for theirs in (ACES_ROLE, *(t for t, _ in _WELL_KNOWN))):
        return False
    return canonical(name, opened) in config_files.display_names(opened.path)


def _through(matrix: Any, pixels: Array) -> Array:
    """Return pixels whose colours went through a matrix."""
    result = np.array(pixels, np.float32)
    result[..., :3] = pixels[..., :3] @ matrix.T.astype(np.float32)
    return result


def convert(pixels: Array, source: str, target: str, ocio: Ocio = None) -> Array:
    """Convert (H, W, 3 or 4) float32 between spaces of the config; alpha stays, nothing is unpremultiplied."""
    found = opened(ocio)  # raises for a config that cannot be read, in whose place OpenImageIO would use another
    buf = oiio.ImageBuf(np.ascontiguousarray(pixels, np.float32))
    result = oiio.ImageBufAlgo.colorconvert(buf, source, target, unpremult=False, colorconfig=found.path)
    if result.has_error:
        problem = said(result.geterror)
        of = "" if found.name == PINNED else f" in the OCIO config {found.name!r}"
        raise ColorError(f"no conversion from {source!r} to {target!r}{of}: {problem}", code="bad-conversion")
    converted = result.get_pixels(oiio.FLOAT)
    return np.asarray(converted, np.float32).reshape(pixels.shape)


def said(geterror: Callable[[], str]) -> str:
    """Return OpenImageIO's message, also where it holds bytes that are no UTF-8, which makes ``geterror`` raise."""
    try:
        return str(geterror())
    except UnicodeDecodeError:
        return "a message that is not UTF-8"


def hint(name: str, known: list[str]) -> str:
    """Return a hint with the nearest of the ``known`` names, or "" where none is near: they are too many to list."""
    text = nearest(name, known)
    return text if text.startswith("did you mean") else ""
