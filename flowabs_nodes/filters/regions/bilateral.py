"""The bilateral filter, full and x-y separable, with which the paper compares the flow-based one (Figs. 16-21)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import BILATERAL_KERNELS
from flowabs_nodes.filters import gaussian, validate
from flowabs_nodes.filters.regions.plane_rows import (
    Planes,
    as_codes,
    as_plane_rows,
    load_color,
    repeat_borders,
    row_of,
    store_mean,
)
from flowabs_nodes.filters.regions.range_weights import (
    Sums,
    WeightExponents,
    add_sample,
    partial_coverage,
    start_sums,
    weight_exponents,
)
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.finite import is_finite, refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES


def bilateral(
    codes: npt.ArrayLike,
    sigma_d: float = 2.0,
    sigma_r: float = 10.0,
    iterations: int = 3,
    kernel: str = "full",
    alpha: npt.ArrayLike | None = None,
) -> Array:
    """Smooth a picture by the bilateral filter of Tomasi and Manduchi [33], ``iterations`` times.

    Each pixel becomes the mean of its neighbours and itself with weights exp(-d^2 / 2 sigma_d^2) times
    exp(-r^2 / 2 sigma_r^2), where d is the distance in pixels and r the Euclidean distance of code values, both to the
    pixel itself.

    Parameters
    ----------
    codes
        Code values, (H, W, 3), not multiplied by alpha.
    sigma_d
        Sigma of the spatial kernel in pixels, 0 to 1,000; 0 gives a copy. The border is repeated.
    sigma_r
        Sigma of the range kernel in code values, above 0.
    iterations
        At least 0; 0 gives a copy.
    kernel
        "full": all neighbours in the square of +-ceil(3 sigma_d). "xy": in each iteration the neighbours in the same
        row, then, in the picture that this gives, the neighbours in the same column (Pham and van Vliet [50]).
    alpha
        Coverage, (H, W). The weight of every neighbour is multiplied by its alpha, so that the colour of an uncovered
        pixel never shows. Pixels with alpha 0 or less keep their value. None is 1 everywhere.

    Returns
    -------
    The smoothed code values, (H, W, 3) float32.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    codes = validate.planes("codes", codes)
    sigma_d = validate.number("sigma_d", sigma_d, min=0, max=1000)
    sigma_r = validate.number("sigma_r", sigma_r, above=0)
    iterations = validate.whole("iterations", iterations, min=0)
    radius = gaussian.radius(sigma_d)
    is_full = validate.choice("kernel", kernel, BILATERAL_KERNELS) == "full"
    windows = [(radius, radius)] if is_full else [(radius, 0), (0, radius)]
    covered = partial_coverage(alpha, codes)

    picture, planes = as_plane_rows(codes, covered, radius)
    smoothed = np.empty_like(picture)
    weights, by_alpha = weight_exponents(sigma_d, sigma_r), None if covered is None else True
    for _ in range(iterations):
        for across, down in windows:
            over_rows(_smooth, planes.height, picture, weights, across, down, planes, by_alpha, smoothed)
            picture, smoothed = smoothed, picture
    result = as_codes(picture, planes, codes)
    if not is_finite(result):
        refuse_overflow("codes", codes, result)
    return result


@kernel
def _smooth(
    first: int,
    last: int,
    picture: Array,
    weights: WeightExponents,
    across: int,
    down: int,
    planes: Planes,
    alpha: bool | None,
    smoothed: Array,
) -> None:
    """Smooth rows ``first`` .. ``last`` - 1 once, over a window of +-``across`` columns and +-``down`` rows."""
    spatial, range_exponent = weights
    for y in range(first, last):
        row, plane = row_of(y, planes)
        for x0 in range(0, planes.stride, LANES):
            x = min(x0, planes.stride - LANES)
            centre = load_color(picture, row + x, plane, alpha)
            sums = start_sums(centre)
            # Opposite neighbours have the same spatial weight, so they are added in pairs.
            for dy in range(down + 1):
                above, _ = row_of(max(y - dy, 0), planes)
                below, _ = row_of(min(y + dy, planes.height - 1), planes)
                for dx in range(-across if dy > 0 else 1, across + 1):
                    near = spatial[abs(dx)] + spatial[dy]
                    sums = _add_neighbour(sums, centre, picture, above + x - dx, plane, near, range_exponent, alpha)
                    sums = _add_neighbour(sums, centre, picture, below + x + dx, plane, near, range_exponent, alpha)
            store_mean(sums, centre, smoothed, row + x, plane, alpha)
        repeat_borders(smoothed, y, planes)


@inlined
def _add_neighbour(
    sums: Sums,
    centre: Color,
    picture: Array,
    i: int,
    plane: int,
    near: float,
    range_exponent: float,
    alpha: bool | None,
) -> Sums:
    """Return the sums with one more neighbour of each centre; ``near`` is log2 of its spatial weight."""
    there = load_color(picture, i, plane, alpha)
    added: Sums = add_sample(sums, centre, there, near, range_exponent, alpha)
    return added
