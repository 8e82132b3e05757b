"""The edge tangent flow (section 2 of the paper), exact, at a cost that grows with the radius and not with its square.

Eq. 1 sums phi w_d t(y) = (t(x).t(y)) t(y) = N(y) t(x) with N = t t^T: eqs. 4 and 5 are the product with a tensor that
does not depend on x. w_m (eq. 3) is linear in ĝ(y). So, k normalising,

    t'(x) = 1/k [(1 - ĝ(x)) sum N + sum ĝN] t(x),

and all that is summed over the kernel is N and ĝN: box sums, taken from running sums down the columns. Of a tensor,
the trace |t|^2 never changes from one iteration to the next; what is left is c = t.x^2 - t.y^2 and s = 2 t.x t.y. The
running sums are integers in fixed point, so their differences are exact: no drift, and the same bits however the
picture is divided among threads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from numba import prange

from flowabs_nodes.filters import arguments, gradient
from flowabs_nodes.filters.adaptive import kernel_choice, radii
from flowabs_nodes.filters.arguments import Array
from flowabs_nodes.filters.flow_fill import flow_fill
from flowabs_nodes.filters.kernels import kernel, parallel_kernel

Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

_BAND = 64  # rows that share running sums


def etf(
    code: npt.ArrayLike,
    radius: float = 5.0,
    iterations: int = 3,
    kernel: str = "full",
    pre_blur: float = 0.0,
    gradient_reference: str | float = "max",
    fill: float | None = 0.0,
    adaptive: bool = False,
) -> Array:
    """Edge tangent flow, eqs. 1-5: a smooth field of tangents that keeps the directions of strong edges.

    The sum of eq. 1 is over the image: pixels of the kernel that lie outside the picture take no part.

    Parameters
    ----------
    code
        Code values, (H, W), or (H, W, 3) for the flow of all channels together (g along the major eigenvector of
        sum_k g_k g_k^T, |g| = sqrt(lambda_1)).
    radius
        Radius mu of the kernel in pixels, at least 0: the open disc dx^2 + dy^2 < radius^2 (eq. 2). Up to 1 it holds
        the centre alone and changes nothing.
    iterations
        How often the field is smoothed (section 2.3); 0 gives the tangents of the gradient.
    kernel
        "full", the disc, or "separable": in each iteration a pass along x and one along y over |d| < radius (2.4).
    pre_blur
        Sigma in pixels of a Gaussian blur of ``code`` before its gradient.
    gradient_reference
        Gradient in code values per pixel that counts as full strength, ĝ = min(|g| / reference, 1): "max" of the
        picture (the paper), a percentile such as "p99.5", or a number of at least 0; a reference of 0 gives ĝ = 0.
    fill
        Gradient in code values per pixel below which a tangent first leans on the average around it, the more the
        weaker it is; 0 fills only where there is no gradient, None leaves zero tangents there (the paper).
    adaptive
        Whether pixels in texture smaller than the kernel take a kernel of half the radius, a quarter and so on, down to
        2.5 pixels (see :mod:`~flowabs_nodes.filters.adaptive`).

    Returns
    -------
    (H, W, 2) float32, unit tangents, x right and y down; the sign has no meaning. An image without any gradient has
    (1, 0) everywhere, zeros with ``fill=None``.

    Raises
    ------
    ArgumentError
        For another shape or dtype, pixels that are not finite, or a parameter out of range.
    """
    code = arguments.plane_or_planes("code", code)
    radius = arguments.number("radius", radius, min=0)
    iterations = arguments.whole("iterations", iterations, min=0)
    kernel = arguments.choice("kernel", kernel, ("full", "separable"))
    pre_blur = arguments.number("pre_blur", pre_blur, min=0, max=10_000)
    gradient.check_reference(gradient_reference)
    fill = None if fill is None else arguments.number("fill", fill, min=0)
    adaptive = arguments.flag("adaptive", adaptive)

    measured = gradient.measured(code, pre_blur)
    tangent, magnitude = measured.gradient
    reference = gradient.reference(measured, gradient_reference)
    strength = np.minimum(magnitude / np.float64(reference), 1).astype(np.float32) if reference else 0 * magnitude
    if fill is not None and not (fill == 0 and measured.everywhere):
        tangent = flow_fill(tangent, magnitude, fill, measured.largest, in_place=True)
    if iterations == 0 or radius <= 1:
        return tangent

    sizes = radii(radius) if adaptive else [radius]
    choice = kernel_choice(code, radius) if len(sizes) > 1 else np.zeros((1, 1), np.uint8)
    # One row for each pass of an iteration; in it, the kernel of each size.
    passes = [
        [_Pass.prepare(tangent, strength, reach) for reach in same_pass]
        for same_pass in zip(*(_shapes(kernel, size, *magnitude.shape) for size in sizes), strict=True)
    ]
    smoothed = np.empty_like(tangent)
    smaller = np.empty_like(tangent if len(sizes) > 1 else tangent[:0])
    for _ in range(iterations):
        for full, *others in passes:
            full.smooth(tangent, strength, smoothed)
            for k, other in enumerate(others, 1):
                other.smooth(tangent, strength, smaller)
                np.copyto(smoothed, smaller, where=(choice == k)[..., np.newaxis])
            tangent, smoothed = smoothed, tangent
    return tangent


# A kernel's shape is its columns: reach[k] is how many pixels the columns k to the left and right go up and down.


def _shapes(kernel: str, radius: float, height: int, width: int) -> list[Int64]:
    """The passes of one iteration."""
    return [_disc(radius, height, width)] if kernel == "full" else _cross(radius, height, width)


def _disc(radius: float, height: int, width: int) -> Int64:
    """Eq. 2: the pixels with dx^2 + dy^2 < radius^2, as far as a picture of this size can hold them."""
    radius = min(radius, math.hypot(height, width) + 1)
    reach = []
    for k in range(min(_steps(radius), width - 1) + 1):
        v = _steps(math.sqrt(radius * radius - k * k))
        v += k * k + (v + 1) ** 2 < radius * radius  # the root may round either way
        v -= k * k + v * v >= radius * radius
        reach.append(min(v, height - 1))
    return np.array(reach)


def _cross(radius: float, height: int, width: int) -> list[Int64]:
    """A row and a column of the pixels with \\|d\\| < radius."""
    radius = min(radius, height + width)
    return [np.zeros(min(_steps(radius), width - 1) + 1, np.int64), np.array([min(_steps(radius), height - 1)])]


def _steps(radius: float) -> int:
    """The largest d < radius."""
    return math.ceil(radius) - 1


@dataclass(frozen=True)
class _Pass:
    """What every iteration of one kernel shape needs: its columns, the fixed point, and the part that never changes."""

    reach: Int64
    scale: np.float32
    trace: Array

    @staticmethod
    def prepare(tangent: Array, strength: Array, reach: Int64) -> _Pass:
        pixels = 2 * int((2 * reach + 1).sum()) - int(2 * reach[0] + 1)
        scale = np.float32(2.0 ** min(20, 30 - pixels.bit_length()))  # no kernel's sum reaches 2^31
        trace = np.empty_like(strength)
        _trace(tangent, strength, reach, scale, trace)
        return _Pass(reach, scale, trace)

    def smooth(self, tangent: Array, strength: Array, smoothed: Array) -> None:
        _smooth(tangent, strength, self.trace, self.reach, self.scale, smoothed)


@parallel_kernel
def _smooth(tangent: Array, strength: Array, trace: Array, reach: Int64, scale: np.float32, smoothed: Array) -> None:
    """One pass of eq. 1."""
    height, width = strength.shape
    for band in prange((height + _BAND - 1) // _BAND):
        first, last = band * _BAND, min((band + 1) * _BAND, height)
        top, bottom = max(first - reach[0], 0), min(last + reach[0], height)
        running = _running_sums(tangent, strength, np.float32(-1), top, bottom, reach.size - 1, scale)
        sums = np.empty((4, width), np.int32)
        for y in range(first, last):
            for p in range(4):  # a loop, since four calls in a row would be inlined and vectorise badly: half the speed
                _kernel_sums(running[p], y - top, reach, sums[p])
            _turn(tangent[y], strength[y], trace[y], sums[0], sums[1], sums[2], sums[3], smoothed[y])


@parallel_kernel
def _trace(tangent: Array, strength: Array, reach: Int64, scale: np.float32, trace: Array) -> None:
    """(1 - ĝ) sum |t|^2 + sum ĝ |t|^2."""
    height, width = strength.shape
    for band in prange((height + _BAND - 1) // _BAND):
        first, last = band * _BAND, min((band + 1) * _BAND, height)
        top, bottom = max(first - reach[0], 0), min(last + reach[0], height)
        running = _running_sums(tangent, strength, np.float32(1), top, bottom, reach.size - 1, scale)
        sums = np.empty((2, width), np.int32)
        for y in range(first, last):
            for p in range(2):
                _kernel_sums(running[p], y - top, reach, sums[p])
            for x in range(width):
                trace[y, x] = (np.float32(1) - strength[y, x]) * np.float32(sums[0, x]) + np.float32(sums[1, x])


@kernel
def _running_sums(
    tangent: Array, strength: Array, sign: np.float32, top: int, bottom: int, margin: int, scale: np.float32
) -> Int32:
    """Sums down each column over the rows top..bottom: c, ĝc, s, ĝs, with empty columns to the left and right.

    c = t.x^2 + sign t.y^2: with sign 1 it is |t|^2. Row i holds the sum of the first i rows.
    """
    width = strength.shape[1]
    running = np.empty((4, bottom - top + 1, width + 2 * margin), np.int32)
    running[:, 0] = 0
    running[:, :, :margin] = 0
    running[:, :, margin + width :] = 0
    for i in range(bottom - top):
        t, g = tangent[top + i], strength[top + i]
        c0, c1 = running[0, i, margin : margin + width], running[0, i + 1, margin : margin + width]
        gc0, gc1 = running[1, i, margin : margin + width], running[1, i + 1, margin : margin + width]
        s0, s1 = running[2, i, margin : margin + width], running[2, i + 1, margin : margin + width]
        gs0, gs1 = running[3, i, margin : margin + width], running[3, i + 1, margin : margin + width]
        for x in range(width):
            c = (t[x, 0] * t[x, 0] + sign * (t[x, 1] * t[x, 1])) * scale
            c1[x] = c0[x] + np.int32(np.rint(c))
            gc1[x] = gc0[x] + np.int32(np.rint(g[x] * c))
        for x in range(width):  # a loop of its own: the compiler vectorises no more than two planes at a time
            s = np.float32(2) * t[x, 0] * t[x, 1] * scale
            s1[x] = s0[x] + np.int32(np.rint(s))
            gs1[x] = gs0[x] + np.int32(np.rint(g[x] * s))
    return running


@kernel
def _kernel_sums(running: Int32, row: int, reach: Int64, total: Int32) -> None:
    """Sum over the kernel at every pixel of a row: the lower ends of its columns less the upper ends."""
    width, margin, end = total.size, reach.size - 1, running.shape[0] - 1
    lower = running[min(row + reach[0] + 1, end)][margin : margin + width]
    upper = running[max(row - reach[0], 0)][margin : margin + width]
    for x in range(width):
        total[x] = lower[x] - upper[x]
    for k in range(1, margin + 1):
        lower, upper = running[min(row + reach[k] + 1, end)], running[max(row - reach[k], 0)]
        lower_left, lower_right = lower[margin - k : margin - k + width], lower[margin + k : margin + k + width]
        upper_left, upper_right = upper[margin - k : margin - k + width], upper[margin + k : margin + k + width]
        for x in range(width):
            total[x] += (lower_left[x] - upper_left[x]) + (lower_right[x] - upper_right[x])


@kernel
def _turn(
    tangent: Array, strength: Array, trace: Array, c: Int32, gc: Int32, s: Int32, gs: Int32, smoothed: Array
) -> None:
    """t' = 1/k M t with M = (1 - ĝ) sum N + sum ĝN from its trace and double angle; a zero tangent stays."""
    for x in range(strength.size):
        weaker = np.float32(1) - strength[x]
        a = trace[x]
        b = weaker * np.float32(c[x]) + np.float32(gc[x])
        d = weaker * np.float32(s[x]) + np.float32(gs[x])
        tx, ty = tangent[x, 0], tangent[x, 1]
        sx = (a + b) * tx + d * ty
        sy = d * tx + (a - b) * ty
        k = np.sqrt(sx * sx + sy * sy)
        stays = k == 0
        k = np.float32(1) if stays else k
        smoothed[x, 0] = tx if stays else sx / k
        smoothed[x, 1] = ty if stays else sy / k
