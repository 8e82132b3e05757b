"""Motion of a plate that has no motion pass: dense inverse search (Kroeger et al. 2016), OpenCV's DIS.

The ways to the frames before and after, p and n, are measured each with an error of its own. What moves evenly has
p = -n, so half of what they differ by, d = p + n, is taken off both, the less the larger it is:

    p - k d / 2,  n - k d / 2,   k = exp(-|d|^2 / (2 EVEN^2)).

T. Kroeger, R. Timofte, D. Dai, L. Van Gool: Fast Optical Flow Using Dense Inverse Search, ECCV 2016.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FLOW_PRESETS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.motion.convention import motion_of
from flowabs_nodes.filters.opencv import MOTION_EXTRA, opencv

#: DIS matches patches of so many pixels a side, so far apart; OpenCV's presets have 8 and 3 to 5. Larger ones stand
#: noise better: lines of a window along them boil a tenth less. OpenCV has a border of 16 around, so no larger ones do.
PATCH, STRIDE = 16, 5
#: In pixels: by how much the ways to the frames before and after may differ where motion counts as even.
EVEN = 1.0

#: Pixels a side of what DIS works on; a patch must fit at a quarter of its size. The border of less is repeated.
_SMALLEST = 4 * PATCH


def optical_flow(
    code: npt.ArrayLike,
    before: npt.ArrayLike | None = None,
    after: npt.ArrayLike | None = None,
    preset: str = "medium",
    pre_blur: float = 1.0,
) -> Array:
    """Find where each pixel comes from on the frame before, and where it goes on the frame after.

    DIS compares 8 bits: code values are rounded, and clipped to 0..255. The result is the same for any number of
    threads.

    Parameters
    ----------
    code, before, after
        Lightness of a frame and its neighbours in code values, (H, W). None: there is no such frame.
    preset
        OpenCV's: "ultrafast", "fast" or "medium", from coarse to fine.
    pre_blur
        Sigma of a Gaussian blur before, in pixels, 0 to 10,000: against noise.

    Returns
    -------
    A motion pass (H, W, 4) float32: X, Y to the place before, -Z, -W to that after, y up. Towards a frame that there is
    not it is 0; nobody can follow it there.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    FlowabsError
        "missing-package" where OpenCV is not installed.
    """
    code = validate.plane("code", code)
    shape = code.shape
    frames = {
        name: None if frame is None else validate.plane(name, frame, shape)
        for name, frame in (("before", before), ("after", after))
    }
    validate.choice("preset", preset, FLOW_PRESETS)
    pre_blur = validate.number("pre_blur", pre_blur, min=0, max=10_000)
    cv2 = opencv("optical_flow", MOTION_EXTRA)
    own = _to_8_bit(code, pre_blur)
    ways = [
        np.zeros((*shape, 2), np.float32) if frame is None else _flow(cv2, own, _to_8_bit(frame, pre_blur), preset)
        for frame in frames.values()
    ]
    if before is not None and after is not None:
        ways = _evened(*ways)
    return motion_of(*(way[: shape[0], : shape[1]] for way in ways))


def _evened(previous: Array, following: Array) -> list[Array]:
    """Return both ways without half of what keeps them from being even, where that is little."""
    d = previous + following
    half = 0.5 * d * np.exp((d * d).sum(axis=2, keepdims=True) * np.float32(-0.5 / EVEN**2))
    return [previous - half, following - half]


def _flow(cv2: Any, one: npt.NDArray[np.uint8], other: npt.NDArray[np.uint8], preset: str) -> Array:
    """Return the way from each pixel of a picture to its place in another one, (H, W, 2), x right and y down."""
    presets = {
        "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
        "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
        "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
    }
    dis = cv2.DISOpticalFlow_create(presets[preset])
    dis.setPatchSize(PATCH)
    dis.setPatchStride(STRIDE)
    flow: Array = dis.calc(one, other, None)
    return flow


def _to_8_bit(code: Array, pre_blur: float) -> npt.NDArray[np.uint8]:
    """Return code values as OpenCV takes them, blurred, and of at least 64 pixels a side."""
    blurred = blur(code, pre_blur) if pre_blur > 0 else code
    missing = [(0, max(0, _SMALLEST - side)) for side in code.shape]
    return np.pad(np.clip(np.rint(blurred), 0, 255).astype(np.uint8), missing, mode="edge")
