"""Find out what an OCIO name means, a scene-linear space, an encoding of one, or data, by converting test colours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np

from flowabs_nodes.array_types import Float64
from flowabs_nodes.color import chromaticities, config, srgb
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


def find(name: str, ocio: str | None = None) -> Named:
    """Return the meaning of ``name`` in the config (the pinned one for None).

    Raises ColorError for a name that the config does not know, with the nearest name, and for a config that cannot be
    read.
    """
    if ocio is not None:
        config.config(ocio)  # raises for a config that cannot be read, also where the name does not need one
    if name.startswith("chromaticities("):
        return Named(name, "linear", chromaticities.parse(name))
    if len(name) > 200:
        raise ColorError(f"{name[:40]!r}... is not the name of a colour space")
    low = name.lower()
    if low in DATA_NAMES:
        return Named(name, "data", KNOWN["lin_rec709"])
    ours = known(name)
    if ours is not None and (ocio is None or name in STANDARD):
        return Named(name, "linear", KNOWN[ours])
    if low in SRGB_NAMES and (ocio is None or low in ("srgb_rec709_scene", "srgb_rec709_display")):
        return Named(name, "srgb", KNOWN["lin_rec709"])
    # OpenImageIO 3.2 tags ACEScct as "ocio:acescct_ap1_scene", which the config knows as "acescct_ap1".
    bare = name.removeprefix("ocio:")
    theirs = next((one for one in (name, bare, bare.removesuffix("_scene")) if config.has(one, ocio)), None)
    if theirs is None:
        if ours is not None:
            return Named(name, "linear", KNOWN[ours])
        if low in CINEON_NAMES:
            return Named(name, "cineon", KNOWN["lin_rec709"])
        hint = config.hint(name, [*KNOWN, "sRGB", "cineon", *config.names(ocio)]) or nearest(name, KNOWN)
        raise ColorError(f"the OCIO config {ocio or config.PINNED} has no colour space {name!r}", hint=hint)
    return _measured(config.canonical(theirs, ocio), ocio)


# Test colours: single channels and sums, for linearity; a ramp of neutrals; neutrals with one channel raised.
_STEPS = (-0.5, 0.18, 1.0, 8.0)
_SINGLE = np.concatenate([step * np.eye(3) for step in _STEPS])
_SUMS = np.array([[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.5, 0.9]])
_RAMP = np.linspace(0, 1, 41)
_LOW, _HIGH = 12, (20, 28)  # indices of 0.3, and of 0.5 and 0.7, on the ramp
_RAISED = np.concatenate([_RAMP[_LOW] + (_RAMP[high] - _RAMP[_LOW]) * np.eye(3) for high in _HIGH])
_PROBES = np.concatenate([_SINGLE, _SUMS, np.repeat(_RAMP[:, None], 3, axis=1), _RAISED])


@cache
def _measured(name: str, ocio: str | None) -> Named:
    """Return the meaning of a config's own name, from how the config converts the test colours to a linear space."""
    theirs, ours = config.reference(ocio)
    sent = config.convert(_PROBES[None].astype(np.float32), name, theirs, ocio)[0].astype(np.float64)
    single, sums, ramp, raised = np.split(sent, np.cumsum([len(_SINGLE), len(_SUMS), len(_RAMP)]))

    matrix = single[6:9].T  # columns: what red, green and blue of 1.0 become
    with np.errstate(all="ignore"):
        expected = np.concatenate([_SINGLE, _SUMS]) @ matrix.T
    if np.allclose(np.concatenate([single, sums]), expected, atol=1e-5, rtol=1e-5):
        if np.allclose(matrix, np.eye(3), atol=1e-6) and name != config.canonical(theirs, ocio):
            return Named(name, "data", KNOWN["lin_rec709"])  # OCIO does not convert data
        if np.allclose(matrix.sum(axis=1), 1, atol=1e-3):
            return Named(name, "linear", _known(matrix, ours, 1e-4) or ColorSpace(name, _to_xyz(matrix, ours)))
        return Named(name, "encoded", KNOWN["lin_ap0_scene"])  # white is not R = G = B: CIE XYZ

    # A curve on each channel, then a matrix: raising one channel gives one column of the matrix, whatever the curve.
    with np.errstate(all="ignore"):  # a curve may be flat here, or end in Inf
        rises = [(raised[3 * i : 3 * i + 3] - ramp[_LOW]).T / (ramp[high] - ramp[_LOW]) for i, high in enumerate(_HIGH)]
    space = None
    if np.isfinite(rises).all() and np.allclose(rises[0], rises[1], atol=2e-3):
        space = _known(rises[0], ours, 3e-3)
    if space == KNOWN["lin_rec709"] and np.allclose(ramp[:, 1], srgb.linear(_RAMP.astype(np.float32)), atol=5e-4):
        return Named(name, "srgb", space)
    return Named(name, "encoded", space or KNOWN["lin_ap0_scene"])  # AP0 holds every colour there is


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
