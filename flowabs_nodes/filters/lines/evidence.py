"""Evidence for a line along a longer stretch of the flow: ink that little other ink continues becomes weaker.

A true edge answers on all of its length, noise and texture here and there. FDoG sums along 3 sigma_m each way; evidence
looks three times as far, and does not make lines longer, as a larger sigma_m would: it only takes away.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian
from flowabs_nodes.filters.flow.flow_blur import along
from flowabs_nodes.filters.flow.flow_resolution import Flows
from flowabs_nodes.sampling.resolution import reduced
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import exp2_of_negative, log2
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import maximum, minimum, select
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels


def stretch(response: Array, flows: Flows, sigma_m: float, factor: int = 1) -> tuple[Array, Array]:
    """Return -N and -B, (h, w): the ink of a response H, and the ink along the longer stretch of each streamline.

    N = max(-H, 0) and B = G(3 sigma_m) along the flow of N, which is read at the nearest pixels: so many make the sum
    that bilinear samples change the ink by less than a percent.

    Parameters
    ----------
    response
        H, (H, W), code values.
    flows
        (H, W, 2), unit tangents.
    sigma_m
        Sigma along the flow in pixels that H was made with.
    factor
        1, 2 or 4, by which N is reduced first, and B with it.
    """
    drawn = np.empty_like(response)  # -N

    def band(first: int, last: int) -> None:
        np.minimum(response[first:last], 0, out=drawn[first:last])

    over_rows(band, response.shape[0])
    drawn, flow = reduced(drawn, factor), flows.reduced(factor)
    weights = gaussian.half(gaussian.LONGER * sigma_m / factor)
    return drawn, along(drawn[None], flow, weights, "nearest")[0]


def weakened(response: Array, ink: Array, stretch: Array, evidence: float) -> Array:
    """Return the response H, weaker where it is below 0 and not on the longer stretch too.

    H becomes H min(1, B / N)^(e/2) where H < 0: in size the geometric mean of N and B for an ``evidence`` e of 1, and H
    itself for 0. What is above 0 stays. ``ink`` is -N, (H, W), and nothing changes where it is above 0; ``stretch`` is
    -B, and counts as 0 where it is above. If they were brought up from a smaller size, the ink of both is as wide.
    """
    run, drawn, along_it, kept = as_run(response), as_run(ink), as_run(stretch), empty_run(response.size)
    over_pixels(_weaken, run.size, run, drawn, along_it, np.float32(evidence / 2), kept)
    return as_picture(kept, *response.shape)


@kernel
def _weaken(first: int, last: int, response: Array, ink: Array, stretch: Array, exponent: float, kept: Array) -> None:
    """Write H min(1, B / N)^``exponent`` where H < 0, else H; for blocks ``first`` .. ``last`` - 1 of sixteen pixels.

    ``ink`` holds -N and ``stretch`` -B.
    """
    for block in range(first, last):
        i = first_pixel(block, response.size)
        h, n = load(response, i), load(ink, i)
        share = select(n < 0.0, minimum(load(stretch, i) / n, 1.0), 1.0)  # -B / -N
        store(kept, i, select(h < 0.0, h * exp2_of_negative(log2(maximum(share, 1e-30)) * exponent), h))
