"""Evidence for a line along a longer stretch of the flow: ink that little other ink continues becomes weaker.

A true edge answers on all of its length, noise and texture here and there. FDoG sums along 3 sigma_m each way; evidence
looks three times as far, and does not make lines longer, as a larger sigma_m would: it only takes away.

A faint line may still be true: a tower in haze, a cable, the far side of a face. What tells it from texture is that it
is alone. With N the ink, B the ink along the stretch and A the ink all around, by Gaussians of the same sigma, A / B is
1 in noise and in texture, whatever their contrast, and near 0 for a single line. Contrast is masked by what surrounds
it (Foley, "Human luminance pattern-vision mechanisms: masking experiments require a new model", 1994), here as there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.flow.flow_blur import along
from flowabs_nodes.filters.flow.flow_resolution import Flows
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.sampling.resolution import reduced
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.elementary import exp2_of_negative, log2
from flowabs_nodes.simd.jit import kernel
from flowabs_nodes.simd.lanes import maximum, minimum, select
from flowabs_nodes.simd.memory import load, store
from flowabs_nodes.simd.pixelwise import as_picture, as_run, empty_run, first_pixel, over_pixels

#: A / B from which on a line is one of many. An endless line of three pixels has 3 / (sqrt(2 pi) sigma).
_MANY = 0.3
#: A in code values at which a lone line is strengthened half as much: what is strong already needs nothing.
_STRONG = 0.1
_NO_INK = 1e-6  # code values of B below which there is no line


class Found(NamedTuple):
    """Ink of a response, and ink around it: code values, (h, w), of one size. Negative, as the response is there."""

    ink: Array  # -N
    along: Array  # -B
    around: Array | None  # -A, where lone lines are asked for

    def each(self, change: Callable[[Array], Array]) -> Found:
        """Return all of them, changed by a function of a plane."""
        return Found(change(self.ink), change(self.along), None if self.around is None else change(self.around))


@dataclass(frozen=True)
class Evidence:
    """What is made of evidence, with the parameters checked."""

    amount: float  # how much weaker ink without evidence becomes, 0 to 1
    lone: float  # how much stronger faint ink becomes that is alone

    @classmethod
    def checked(cls, evidence: float, lone_lines: float) -> Evidence | None:
        """Return what is made of evidence, None where nothing is; raise ArgumentError for a bad parameter."""
        amount = validate.number("evidence", evidence, min=0, max=1)
        lone = validate.number("lone_lines", lone_lines, min=0, max=1000)
        return None if amount == lone == 0 else cls(amount, lone)

    def found(self, response: Array, flows: Flows, sigma_m: float, factor: int = 1) -> Found:
        """Return the ink of a response H, along the longer stretch of each streamline and around each pixel.

        N = max(-H, 0), B = G(3 sigma_m) along the flow of N, which is read at the nearest pixels: so many make the sum
        that bilinear samples change the ink by less than a percent. A = G(3 sigma_m) of N in the plane.

        Parameters
        ----------
        response
            H, (H, W), code values.
        flows
            (H, W, 2), unit tangents.
        sigma_m
            Sigma along the flow in pixels that H was made with.
        factor
            1, 2 or 4, by which N is reduced first, and the others with it.
        """
        drawn = np.empty_like(response)  # -N

        def band(first: int, last: int) -> None:
            np.minimum(response[first:last], 0, out=drawn[first:last])

        over_rows(band, response.shape[0])
        drawn, flow = reduced(drawn, factor), flows.reduced(factor)
        sigma = gaussian.LONGER * sigma_m / factor
        stretch = along(drawn[None], flow, gaussian.half(sigma), "nearest")[0]
        return Found(drawn, stretch, blur(drawn, sigma) if self.lone > 0 else None)

    def weighed(self, response: Array, found: Found) -> Array:
        """Return the response H, weaker where it is below 0 and not on the longer stretch too, stronger where alone.

        H becomes H min(1, B / N)^(e/2) where H < 0: in size the geometric mean of N and B for an ``amount`` e of 1, and
        H itself for 0. Then it is multiplied by 1 + l max(0, 1 - A / (0.3 B)) / (1 + A / 0.1), l being ``lone``. What
        is above 0 stays. Nothing becomes weaker where -N is above 0, and -B counts as 0 where it is above. If all were
        brought up from a smaller size, the ink of each is as wide.
        """
        run, kept = as_run(response), empty_run(response.size)
        around = empty_run(0) if found.around is None else as_run(found.around)
        rule = np.float32(self.amount / 2), np.float32(self.lone)
        over_pixels(_weigh, run.size, run, as_run(found.ink), as_run(found.along), around, *rule, kept)
        return as_picture(kept, *response.shape)


@kernel
def _weigh(
    first: int,
    last: int,
    response: Array,
    ink: Array,
    stretch: Array,
    around: Array,
    exponent: float,
    lone: float,
    kept: Array,
) -> None:
    """Write what :meth:`Evidence.weighed` returns for blocks ``first`` .. ``last`` - 1 of sixteen pixels.

    ``ink`` holds -N, ``stretch`` -B and ``around`` -A, or no pixels where nothing is strengthened.
    """
    for block in range(first, last):
        i = first_pixel(block, response.size)
        h, n, b = load(response, i), load(ink, i), load(stretch, i)
        share = select(n < 0.0, minimum(b / n, 1.0), 1.0)
        weighed = h * exp2_of_negative(log2(maximum(share, 1e-30)) * exponent)
        if around.size > 0:
            a = maximum(-load(around, i), 0.0)
            alone = maximum(1.0 - a / maximum(-b, _NO_INK) * (1 / _MANY), 0.0)
            weighed = weighed * (1.0 + lone * alone / (1.0 + a * (1 / _STRONG)))
        store(kept, i, select(h < 0.0, weighed, h))
