"""Line integral convolution (LIC): a flow shown as streaks of noise, as the paper shows its flows (Fig. 3)."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.flow.flow_blur import along

SPREAD = 0.2  # standard deviation of the streaks at contrast 1


def lic(flow: npt.ArrayLike, length: float = 20.0, seed: int = 1, contrast: float = 1.0) -> Array:
    """Average white noise along the streamlines of a flow, round(length / 2) steps each way with equal weights.

    Parameters
    ----------
    flow
        (H, W, 2), unit tangents, x right and y down; the sign has no meaning.
    length
        Length of the streaks in pixels, 0 to 20,000.
    seed
        Seed of the noise, at least 0. Noise and result are the same for the same seed, size and flow.
    contrast
        Spread of the streaks about 0.5, at least 0: 1 is a standard deviation of about 0.2 for any ``length``. The
        spread does not depend on the flow, so that the frames of a shot look alike.

    Returns
    -------
    (H, W) float32, 0 to 1.

    Raises
    ------
    ArgumentError
        For another shape or dtype, a flow that is not finite, or a parameter out of range.
    """
    flow = validate.flow_field(flow)
    steps = round(validate.number("length", length, min=0, max=20_000) / 2)
    seed = validate.whole("seed", seed, min=0)
    contrast = validate.number("contrast", contrast, min=0, max=1e6)
    noise = np.random.default_rng(seed).random(flow.shape[:2], np.float32)
    samples = 2 * steps + 1
    streaks = along(noise[None], flow, np.full(steps + 1, 1 / samples), "bilinear")[0]
    deviation = math.sqrt(1 / 12 / samples)  # of the mean of so many random numbers from 0..1
    picture: Array = np.clip(0.5 + np.float32(contrast * SPREAD / deviation) * (streaks - np.float32(0.5)), 0, 1)
    return picture
