"""Mean-shift segmentation [28] by OpenCV, with which the paper compares FBL (Figs. 14c, 21)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.opencv import opencv
from flowabs_nodes.filters.regions.merge import flatten_regions
from flowabs_nodes.simd.premultiplied import TINY

EightBit = npt.NDArray[np.uint8]

#: A pixel's climb ends when its mean moves by less than 0.1 (pixels and code values), or after 100 steps.
_STEPS, _MOVE = 100, 0.1


def mean_shift(
    codes: npt.ArrayLike,
    spatial: float = 10.0,
    range: float = 5.0,
    min_region: int = 20,
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Give each pixel the colour of the mode it climbs to, then each connected region of like colour its mean colour.

    The modes come from OpenCV's ``pyrMeanShiftFiltering`` without a pyramid, on OpenCV's 8-bit Lab: L* times 2.55, a*
    and b* plus 128. Values beyond 8 bits are clipped (:func:`measure_clipping` counts such pixels). Then regions
    smaller than ``min_region`` merge with the neighbouring region that is nearest in mean colour.

    Parameters
    ----------
    codes
        Code values of Lab, (H, W, 3): L*, a*, b* times 2.55.
    spatial
        Radius in pixels, 0 to 1,000, which OpenCV rounds: h_s of the paper's section 4.1.
    range
        Radius in colour, 0 to 255, in units of 8-bit Lab: h_r. Neighbouring pixels belong to one region where their
        modes differ by at most half of it.
    min_region
        Fewest pixels that a region may have: M. 1 merges nothing; 0 leaves regions out, and modes as they are.
    alpha
        Coverage, (H, W). Pixels with alpha 0 or less keep their value, and belong to no region; OpenCV weighs
        all others alike.

    Returns
    -------
    The segmented code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    FlowabsError
        "missing-package" where OpenCV is not installed.
    """
    codes = validate.planes("codes", codes)
    spatial = validate.number("spatial", spatial, min=0, max=1000)
    range = validate.number("range", range, min=0, max=255)
    min_region = validate.whole("min_region", min_region, min=0, max=2**31 - 1)
    covered = np.ones(codes.shape[:2], bool) if alpha is None else validate.plane("alpha", alpha, codes.shape) > TINY
    cv2 = opencv("mean_shift")
    stop = (cv2.TERM_CRITERIA_MAX_ITER | cv2.TERM_CRITERIA_EPS, _STEPS, _MOVE)
    modes = cv2.pyrMeanShiftFiltering(_to_8_bit(codes), spatial, range, maxLevel=0, termcrit=stop).astype(np.float32)
    if min_region > 0:
        flatten_regions(modes, covered, range / 2, min_region)
    modes[..., 1:] = (modes[..., 1:] - 128) * np.float32(2.55)
    return np.where(covered[..., None], modes, codes)


def measure_clipping(codes: npt.ArrayLike) -> int:
    """Return how many pixels of Lab code values (H, W, 3) :func:`mean_shift` clips to 8 bits."""
    lab = _in_8_bit_units(validate.planes("codes", codes))
    return int(((lab < -0.5) | (lab > 255.5)).any(axis=2).sum())


def _in_8_bit_units(codes: Array) -> Array:
    """Return Lab code values (H, W, 3) in OpenCV's units, neither rounded nor clipped."""
    lab = codes.copy()
    lab[..., 1:] = lab[..., 1:] / np.float32(2.55) + 128
    return lab


def _to_8_bit(codes: Array) -> EightBit:
    """Return Lab code values (H, W, 3) as OpenCV's 8-bit Lab."""
    return np.clip(np.rint(_in_8_bit_units(codes)), 0, 255).astype(np.uint8)
