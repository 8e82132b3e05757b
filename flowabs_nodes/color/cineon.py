"""Kodak's Cineon curve, the log of a scanned negative, as comp packages have it: black is code 95, white 685 of 1023.

Not in the pinned OCIO config. The equation is colour-science's ``log_encoding_Cineon``: 0.002 of printing density a
code over a negative's gamma of 0.6 is 300 codes a decade.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]

_WHITE, _BLACK = 685.0, 95.0
_CODES_PER_DECADE = 300.0
_FLARE = 10 ** ((_BLACK - _WHITE) / _CODES_PER_DECADE)  # what black is on the negative, of white
_CODE_ZERO = 10 ** (-_WHITE / _CODES_PER_DECADE)


def linear(codes: Array) -> Array:
    """Return the linear light of Cineon codes, 0..1 of 1023: 95 is 0, 685 is 1, 1023 is 13.5, and 0 is -0.006."""
    density = (codes * np.float32(1023) - np.float32(_WHITE)) * np.float32(1 / _CODES_PER_DECADE)
    return np.asarray((np.float32(10) ** density - np.float32(_FLARE)) * np.float32(1 / (1 - _FLARE)), np.float32)


def encoded(rgb: Array) -> Array:
    """Return the Cineon codes, 0..1 of 1023, of linear light: the inverse of :func:`linear`; 0 for all below code 0."""
    negative = np.maximum(rgb * np.float32(1 - _FLARE) + np.float32(_FLARE), np.float32(_CODE_ZERO))
    codes = np.log10(negative) * np.float32(_CODES_PER_DECADE) + np.float32(_WHITE)
    return np.asarray(codes * np.float32(1 / 1023), np.float32)
