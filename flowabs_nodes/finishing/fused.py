"""Fused decode, quantise and ink: one pass in which each pixel is read and written once.

The kernels take pictures as runs of pixels (:mod:`~flowabs_nodes.simd.pixelwise`), and a run of no pixels where there
is no such picture: codes (pixels x 3), ``under`` (pixels x 4, premultiplied RGBA), lines (pixels). ``first`` and
``last`` bound blocks of sixteen pixels. Each kernel returns whether it wrote a number that is not finite.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from flowabs_nodes.array_types import Array
from flowabs_nodes.color import acescct, lab
from flowabs_nodes.color.codes import BARE, NOTHING, Codes, matrices
from flowabs_nodes.color.spaces import ColorSpace
from flowabs_nodes.filters.compositing import InkColor, over
from flowabs_nodes.filters.regions.quantize import Steps, flatten
from flowabs_nodes.finishing.operations import Ink, Quantize
from flowabs_nodes.simd.finite import refuse_overflow
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.known_finite import mark_finite
from flowabs_nodes.simd.lanes import maximum, minimum, select, splat_floats
from flowabs_nodes.simd.matrix3 import Rows, mix, mix_second_row
from flowabs_nodes.simd.memory import load, load_triples, store_quads, store_triples
from flowabs_nodes.simd.pixelwise import any_nan, as_picture, as_run, empty_run, first_pixel, over_pixels, zero_or_nan
from flowabs_nodes.simd.premultiplied import TINY, load_rgb_over_ground, load_rgba, premultiplied_over

_NO_INK: InkColor = (0.0, 0.0, 0.0, 0.0)


class Flat(NamedTuple):
    """How colours are flattened, as one argument of a kernel."""

    steps: Steps  # 0 bins per L* where they are not
    chroma: float  # gain on a* and b*
    rises: Array  # a run, the rise of L*; no pixels where it does not count


class Drawing(NamedTuple):
    """Lines and their ink, as one argument of a kernel."""

    lines: Array  # a run, 1 paper and 0 ink; no pixels where there is no ink
    ink: InkColor


def decoded(codes: Codes, quantize: Quantize | None, ink: Ink | None, colorspace: ColorSpace) -> Array:
    """Return the picture that code values decode to in ``colorspace``, quantised and with ink over it where given.

    The result is scene-linear float32, (H, W, 3), or premultiplied (H, W, 4) if ``codes.under`` has alpha. Only code
    values of "lab" can be quantised on the way. ArgumentError for code values that are not finite.
    """
    if quantize is None and ink is None:
        return codes.decode(colorspace)
    height, width, channels = codes.shape
    run, below = as_run(codes.values, 3), NOTHING if codes.under is None else as_run(codes.under, 4)
    drawing = Drawing(NOTHING, _NO_INK) if ink is None else Drawing(as_run(ink.lines), (*ink.color, ink.opacity))
    count = run.size // 3
    pixels, backward = empty_run(count, channels), matrices(codes.space, colorspace).backward
    if codes.space == "lab":
        flat = Flat(Steps(0.0, 0.0), 1.0, NOTHING) if quantize is None else _flat(quantize)
        bad = over_pixels(_finish_lab, count, run, backward, flat, below, drawing, pixels)
    else:
        bad = over_pixels(_finish_acescct, count, run, backward, below, drawing, pixels)
    picture = as_picture(pixels, height, width, channels)
    if any(bad):
        refuse_overflow("codes", codes.values, picture)
    return mark_finite(picture)


def _flat(quantize: Quantize) -> Flat:
    """Return ``quantize`` as kernels take it."""
    levels, softness, phase, chroma, by_gradient, hard_gradient, rises = quantize
    steps = Steps(levels / 100, softness, phase, by_gradient, 1 / hard_gradient)
    return Flat(steps, chroma, NOTHING if rises is None else as_run(rises))


def quantized(pixels: Array, quantize: Quantize, colorspace: ColorSpace) -> Array:
    """Return a scene-linear picture with L* quantised by a gain on RGB, and with its chroma, as ``quantize`` says.

    ``pixels`` is (H, W, 3) or premultiplied (H, W, 4) float32; the result has the same shape. ArgumentError for pixels
    that are not finite.
    """
    channels = pixels.shape[2]
    run = as_run(pixels, channels)
    count = run.size // channels
    forward, backward, _ = matrices("lab", colorspace)
    made = empty_run(count, channels)
    picture = as_picture(made, *pixels.shape)
    if any(over_pixels(_quantize, count, run, channels, (forward, backward), _flat(quantize), made)):
        refuse_overflow("rgb", pixels, picture)
    return mark_finite(picture)


# Alpha and ink stand in both kernels: a function of them that branches on arrays takes the kernel twice the time.


@kernel
def _finish_lab(
    first: int, last: int, codes: Array, from_xyz: Rows, flat: Flat, under: Array, drawing: Drawing, pixels: Array
) -> Any:
    """Decode L*, a*, b*, quantise unless there are 0 bins per L*, then apply alpha and ink."""
    (steps, chroma, rises), (lines, ink) = flat, drawing
    total, count = splat_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_pixel(block, count)
        lightness, a, b = load_triples(codes, 3 * i)
        if chroma != 1:
            more = 1.0 + _share(lightness * (1 / 2.55)) * (chroma - 1.0)
            a, b = a * more, b * more
        red, green, blue = lab.to_rgb(lightness, a, b, from_xyz)
        if steps.per > 0:
            steep = splat_floats(0.0)
            if rises.size > 0:
                steep = load(rises, i)
            gain = _gain(lightness * (1 / lab.L), steep, steps)
            red, green, blue = red * gain, green * gain, blue * gain
        alpha = splat_floats(1.0)
        if under.size > 0:
            red, green, blue, alpha = premultiplied_over(red, green, blue, under, i)
        if lines.size > 0:
            red, green, blue = over(red, green, blue, alpha, load(lines, i), ink)
        total = total + (zero_or_nan(red) + zero_or_nan(green) + zero_or_nan(blue))
        if under.size > 0:
            store_quads(pixels, 4 * i, (red, green, blue, alpha))
        else:
            store_triples(pixels, 3 * i, (red, green, blue))
    return any_nan(total)


@kernel
def _finish_acescct(
    first: int, last: int, codes: Array, from_ap1: Rows, under: Array, drawing: Drawing, pixels: Array
) -> Any:
    """Decode ACEScct, then apply alpha and ink."""
    lines, ink = drawing
    total, count = splat_floats(0.0), codes.size // 3
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_triples(codes, 3 * i)
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))  # acescct decodes an Inf to a finite number
        red, green, blue = acescct.to_rgb(r, g, b, from_ap1)
        alpha = splat_floats(1.0)
        if under.size > 0:
            red, green, blue, alpha = premultiplied_over(red, green, blue, under, i)
        if lines.size > 0:
            red, green, blue = over(red, green, blue, alpha, load(lines, i), ink)
        total = total + (zero_or_nan(red) + zero_or_nan(green) + zero_or_nan(blue))
        if under.size > 0:
            store_quads(pixels, 4 * i, (red, green, blue, alpha))
        else:
            store_triples(pixels, 3 * i, (red, green, blue))
    return any_nan(total)


@kernel
def _quantize(
    first: int, last: int, pixels: Array, channels: int, xyz: tuple[Rows, Rows], flat: Flat, made: Array
) -> Any:
    """Quantise a picture of (pixels x channels,); alpha stays, and so do colours where alpha is 0.

    ``xyz`` are the matrices to and from XYZ.
    """
    (to_xyz, from_xyz), (steps, chroma, rises) = xyz, flat
    total, count = splat_floats(0.0), pixels.size // channels
    for block in range(first, last):
        i = first_pixel(block, count)
        r, g, b = load_rgb_over_ground(pixels, channels, BARE, i)
        gy, steep = lab.g_of(mix_second_row(to_xyz, r, g, b)), splat_floats(0.0)
        if rises.size > 0:
            steep = load(rises, i)
        gain = _gain(gy, steep, steps)
        if chroma != 1:
            red, green, blue = _with_chroma((r, g, b), gy, chroma, to_xyz, from_xyz)
        r, g, b, a = load_rgba(pixels, channels, i)
        if chroma != 1:
            changes = a * _share(116.0 * gy) > 0.0
            r, g, b = select(changes, red * a, r), select(changes, green * a, g), select(changes, blue * a, b)
        gain = select(a > TINY, gain, splat_floats(1.0))
        r, g, b = r * gain, g * gain, b * gain
        total = total + (zero_or_nan(r) + zero_or_nan(g) + zero_or_nan(b))
        if channels == 4:
            store_quads(made, 4 * i, (r, g, b, a))
        else:
            store_triples(made, 3 * i, (r, g, b))
    return any_nan(total)


@inlined
def _gain(gy: Any, steep: Any, steps: Steps) -> Any:
    """Return the gain on the RGB of sixteen pixels that takes L* = 116 ``gy`` (color/lab.py), of that rise, to Q.

    It is Y(Q) / Y(L*) from L* 8 up, and comes down to 1 at L* 1: Y(L*) is next to nothing there, and so is the pixel,
    but for noise. At and below zero luminance a pixel stays what it is.
    """
    lightness = 116.0 * gy
    above = maximum(lightness, 1.0)
    gain = lab.g_inverse(flatten(lightness, steep, steps) * (1 / 116)) / lab.g_inverse(above * (1 / 116))
    share = _share(lightness)
    return gain * share + (1.0 - share)


@inlined
def _share(lightness: Any) -> Any:
    """Return how much of the flattening sixteen L* get: all from L* 8 up, nothing at L* 1 and below."""
    return minimum(maximum(lightness, 1.0) * (1 / 7) - (1 / 7), 1.0)


@inlined
def _with_chroma(rgb: Any, gy: Any, chroma: float, to_xyz: Rows, from_xyz: Rows) -> Any:
    """Return the RGB of sixteen pixels, of g(Y) ``gy``, with a* and b* times ``chroma``."""
    x, _, z = mix(to_xyz, rgb[0], rgb[1], rgb[2])
    more = 1.0 + _share(116.0 * gy) * (chroma - 1.0)
    gx, gz = gy + (lab.g_of(x) - gy) * more, gy + (lab.g_of(z) - gy) * more
    return mix(from_xyz, lab.g_inverse(gx), lab.g_inverse(gy), lab.g_inverse(gz))
