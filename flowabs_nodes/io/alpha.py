"""What a file's alpha means, and how its pixels become premultiplied and scene-linear."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import OpenImageIO as oiio

Array = npt.NDArray[np.float32]


def is_straight(spec: oiio.ImageSpec, kind: str) -> bool:
    """True if a file's colour is not multiplied by its alpha: always in PNG, in TIFF if it says so, never in EXR."""
    return kind == "png" or (kind == "tiff" and spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 1)


def premultiplied(rgb: Array, alpha: Array) -> Array:
    """(H, W, 3) straight colour times its (H, W) alpha."""
    return np.asarray(rgb * alpha[..., None], np.float32)


def straight(rgb: Array, alpha: Array) -> Array:
    """(H, W, 3) premultiplied colour over its (H, W) alpha; where that is 0 or less, as it is."""
    a = alpha[..., None]
    return np.divide(rgb, a, out=rgb.copy(), where=a > 0)
