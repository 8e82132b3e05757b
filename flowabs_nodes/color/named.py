"""Find out what an OCIO name means, a scene-linear space, an encoding of one, or data, by converting test colours.

A name is the config's first. Names that it lacks and that mean the same everywhere come from us: those of the known
spaces, of sRGB, Cineon and data, and from the pinned config those of ACES and of the Color Interop Forum.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from flowabs_nodes.array_types import Float64
from flowabs_nodes.color import chromaticities, config, srgb
from flowabs_nodes.color.config import Config, Ocio, opened
from flowabs_nodes.color.constants import Matrix
from flowabs_nodes.color.spaces import KNOWN, STANDARD, ColorSpace, between, known
from flowabs_nodes.errors import ColorError, nearest

#: Names of sRGB pictures, scene- or display-referred: OIIO's, OCIO's and the Color Interop Forum's, in lower case.
SRGB_NAMES = frozenset(
    (
        *("srgb", "srgb_rec709_scene", "srgb_rec709_display", "srgb_tx", "srgb_texture", "srgb_display"),
        *("srgb - texture", "srgb - display", "srgb encoded rec.709 (srgb)", "utility - srgb - texture"),
    )
)
#: Names of the log of scanned film, where the config has none of its own: Nuke's, and OpenImageIO's for a DPX.
CINEON_NAMES = frozenset(("cineon", "kodaklog"))
#: Names of data that is no colour, in lower case.
DATA_NAMES = frozenset(("data", "raw", "none", "utility - raw", "non-color"))


@dataclass(frozen=True)
class Named:
    """The meaning of a name in a config."""

    name: str  # the config's own name
    kind: Literal["linear", "srgb", "cineon", "encoded", "data"]
    space: ColorSpace  # the scene-linear space that its colours are brought to
    config: Config  # the config that knows it


def find(name: str, ocio: Ocio = None) -> Named:
    """Return the meaning of ``name`` in the config (the pinned one for None).

    Raises ColorError for a name that the config does not know, with the nearest name, for a name of a config that
    cannot be tied to others, and for a config that cannot be read, also where the name does not need one.
    """
    own = opened(ocio)
    if name.startswith("chromaticities("):
        return Named(name, "linear", chromaticities.parse(name), own)
    if len(name) > 200:
        raise ColorError(f"{name[:40]!r}... is not the name of a colour space")
    low = name.lower()
    if low in DATA_NAMES:
        return Named(name, "data", KNOWN["lin_rec709"], own)
    ours, pinned = known(name), not own.content
    if ours is not None and (pinned or name in STANDARD):
        return Named(name, "linear", KNOWN[ours], own)
    if low in SRGB_NAMES and (pinned or low in ("srgb_rec709_scene", "srgb_rec709_display")):
        return Named(name, "srgb", KNOWN["lin_rec709"], own)
    theirs = _known_as(name, own)
    if theirs is not None:
        return _measured(config.canonical(theirs, own), own)
    if ours is not None:
        return Named(name, "linear", KNOWN[ours], own)
    if low in SRGB_NAMES:
        return Named(name, "srgb", KNOWN["lin_rec709"], own)
    if low in CINEON_NAMES:
        return Named(name, "cineon", KNOWN["lin_rec709"], own)
    if not pinned and means_the_same_everywhere(name) and _known_as(name, opened()) is not None:
        return find(name)
    candidates = [*KNOWN, "sRGB", "cineon", *config.names(own)]
    if not pinned:
        candidates += [each for each in config.names() if means_the_same_everywhere(each)]
    hint = config.hint(name, candidates) or nearest(name, KNOWN)
    if not pinned and config.has(name):
        hint = f"the built-in config has it: {config.PINNED}"
    raise ColorError(f"the OCIO config {own.name} has no colour space {name!r}", hint=hint)


def means_the_same_everywhere(name: str) -> bool:
    """Return whether a name of the pinned config is one of ACES or the Color Interop Forum."""
    low = name.lower().removeprefix("ocio:")
    return low.startswith("aces") or low.endswith(("_scene", "_display"))


def _known_as(name: str, own: Config) -> str | None:
    """Return the spelling under which a config knows a name; None where it does not.

    OpenImageIO 3.2 tags ACEScct as "ocio:acescct_ap1_scene", which the pinned config knows as "acescct_ap1".
    """
    bare = name.removeprefix("ocio:")
    return next((one for one in (name, bare, bare.removesuffix("_scene")) if config.has(one, own)), None)


# Test colours: single channels and sums, for linearity; a ramp of neutrals; neutrals with one channel raised.
_STEPS = (-0.5, 0.18, 1.0, 8.0)
_SINGLE = np.concatenate([step * np.eye(3) for step in _STEPS])
_SUMS = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.5, 0.9]])
_RAMP = np.linspace(0, 1, 41)
_LOW, _HIGH = 12, (20, 28)  # indices of 0.3, and of 0.5 and 0.7, on the ramp
_RAISED = np.concatenate([_RAMP[_LOW] + (_RAMP[high] - _RAMP[_LOW]) * np.eye(3) for high in _HIGH])
_PROBES = np.concatenate([_SINGLE, _SUMS, np.repeat(_RAMP[:, None], 3, axis=1), _RAISED])


@cache
def _measured(name: str, own: Config) -> Named:
    """Return the meaning of a config's own name, from how the config converts the test colours to a linear space."""
    if config.is_data(name, own):
        return Named(name, "data", KNOWN["lin_rec709"], own)
    converted, ours = config.to_known(_PROBES[None].astype(np.float32), name, own)
    sent = converted[0].astype(np.float64)
    single, sums, ramp, raised = np.split(sent, np.cumsum([len(_SINGLE), len(_SUMS), len(_RAMP)]))

    matrix = single[6:9].T  # columns: what red, green and blue of 1.0 become
    with np.errstate(all="ignore"):
        expected = np.concatenate([_SINGLE, _SUMS]) @ matrix.T
    if np.allclose(np.concatenate([single, sums]), expected, atol=1e-5, rtol=1e-5):
        if np.allclose(matrix.sum(axis=1), 1, atol=1e-3):
            return Named(name, "linear", _known(matrix, ours, 1e-4) or ColorSpace(name, _to_xyz(matrix, ours)), own)
        return Named(name, "encoded", KNOWN["lin_ap0_scene"], own)  # white is not R = G = B: CIE XYZ

    # A curve on each channel, then a matrix: raising one channel gives one column of the matrix, whatever the curve.
    with np.errstate(all="ignore"):  # a curve may be flat here, or end in Inf
        rises = [(raised[3 * i : 3 * i + 3] - ramp[_LOW]).T / (ramp[high] - ramp[_LOW]) for i, high in enumerate(_HIGH)]
    space = None
    if np.isfinite(rises).all() and np.allclose(rises[0], rises[1], atol=2e-3):
        space = _known(rises[0], ours, 3e-3)
    if space == KNOWN["lin_rec709"] and np.allclose(ramp[:, 1], srgb.linear(_RAMP.astype(np.float32)), atol=5e-4):
        return Named(name, "srgb", space, own)
    return Named(name, "encoded", space or KNOWN["lin_ap0_scene"], own)  # AP0 holds every colour there is


def _known(matrix: Float64, reference: str, tolerance: float) -> ColorSpace | None:
    """Return the known space with this matrix to the space ``reference``, or None."""
    for space in KNOWN.values():
        if np.allclose(matrix, between(space, KNOWN[reference]), atol=tolerance, rtol=0):
            return space
    return None


def _to_xyz(matrix: Float64, reference: str) -> Matrix:
    """Return the matrix to XYZ of a space with this matrix to the space ``reference``."""
    m = (np.array(KNOWN[reference].to_xyz).reshape(3, 3) @ matrix).ravel().tolist()
    return (m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8])
