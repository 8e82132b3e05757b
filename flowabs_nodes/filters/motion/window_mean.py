"""The mean over a window: each pixel's own value, and what it sees at its places on the other frames.

    v = v_0 + sum w_k (v_k - v_0) / (1 + sum w_k)

v_0 counts with weight 1, so that every pixel has a mean. Written so, a pixel that has no place, or sees the same at all
of them, keeps its bits. v_k is read bilinearly.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.motion.places import (
    Pairs,
    Path,
    Place,
    addresses,
    corner_pairs,
    corner_triples,
    mix4,
    place_of,
    sample_plane,
)
from flowabs_nodes.filters.regions.range_weights import load_color
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.sampling.samples import Color
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES, Floats, absolute, select, splat_floats, sqrt
from flowabs_nodes.simd.memory import (
    address,
    gather_octets,
    load,
    load_pairs,
    scratch,
    store,
    store_pairs,
    store_triples,
)
from flowabs_nodes.simd.premultiplied import TINY

#: The most frames beside a pixel's own: kernels take a tuple of so many pictures, of which the first ``count`` matter.
MOST = 8


@kernel
def mean_of_planes(
    first: int, last: int, raster: Raster, own: Array, others: tuple[Array, ...], count: int, paths: Path, mean: Array
) -> None:
    """Write the mean of a picture of one channel, (H x stride,), for the rows ``first`` .. ``last`` - 1.

    ``others`` are the same picture on ``count`` other frames, and ``paths`` the ways to the places there, one after
    the other.
    """
    stride = raster.stride
    size = (last - first) * stride
    paths, pictures = addresses(paths), _addresses_of(others)
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, (y - first) * stride + x
            value = load(own, pixel)
            total, weights = splat_floats(0.0), splat_floats(1.0)
            for k in range(count):
                place, weight = place_of(paths, k * size + at, raster), load(paths.weight, k * size + at)
                there = sample_plane(pictures[k], place)
                total, weights = total + weight * (there - value), weights + weight
            store(mean, pixel, value + total / weights)


@kernel
def mean_of_colors(
    first: int,
    last: int,
    raster: Raster,
    own: Array,
    others: tuple[Array, ...],
    count: int,
    paths: Path,
    mean: Array,
    alpha: bool | None,
) -> None:
    """Write the mean of code values, as :func:`mean_of_planes` does, (H x stride x 3,).

    Pictures are records of three floats, as :func:`~.places.rows_of_triples` gives them, or with ``alpha`` True of
    four. Each weight, the own too, is multiplied by alpha then, so that no colour counts where there is none.
    """
    stride, records = raster.stride, scratch(np.int32, 1)
    size = (last - first) * stride
    paths, pictures = addresses(paths), _addresses_of(others)
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, (y - first) * stride + x
            value = load_color(own, pixel, alpha)
            l = a = b = splat_floats(0.0)  # noqa: E741
            weights = splat_floats(1.0) if alpha is None else value.alpha
            for k in range(count):
                place, weight = place_of(paths, k * size + at, raster), load(paths.weight, k * size + at)
                there = _sample_color(pictures[k], place, records, raster, alpha)
                if alpha is not None:
                    weight = weight * there.alpha
                l = l + weight * (there.l - value.l)  # noqa: E741
                a, b = a + weight * (there.a - value.a), b + weight * (there.b - value.b)
                weights = weights + weight
            share = select(weights > TINY, 1.0 / weights, splat_floats(0.0))
            store_triples(mean, 3 * pixel, (value.l + share * l, value.a + share * a, value.b + share * b))


@inlined
def _addresses_of(pictures: tuple[Array, ...]) -> tuple[Array, ...]:
    """Return the memory of ``MOST`` pictures."""
    a, b, c, d, e, f, g, h = pictures
    return (
        address(a, 0),
        address(b, 0),
        address(c, 0),
        address(d, 0),
        address(e, 0),
        address(f, 0),
        address(g, 0),
        address(h, 0),
    )


@inlined
def _sample_color(picture: Array, at: Place, records: Int32, raster: Raster, alpha: bool | None) -> Color:
    """Return the colours of records at the places; with ``alpha`` each of the four counts as far as it covers.

    ``records`` is memory for sixteen indices.
    """
    if alpha is None:
        store(records, 0, 3 * load(at.corner, at.at))
        (p, q, r), (s, t, u), (i, j, k), (l, m, n) = corner_triples(picture, records, 0, raster)  # noqa: E741
        return Color(mix4(p, s, i, l, at), mix4(q, t, j, m, at), mix4(r, u, k, n, at), splat_floats(1.0))
    store(records, 0, 4 * load(at.corner, at.at))
    p, q, r, s, t, u, v, w = gather_octets(picture, records, 0)
    i, j, k, l, m, n, o, z = gather_octets(address(picture, 4 * at.below), records, 0)  # noqa: E741
    covered = mix4(s, w, l, z, at)
    inverse = select(covered > TINY, 1.0 / covered, splat_floats(0.0))
    return Color(
        inverse * mix4(s * p, w * t, l * i, z * m, at),
        inverse * mix4(s * q, w * u, l * j, z * n, at),
        inverse * mix4(s * r, w * v, l * k, z * o, at),
        covered,
    )


@kernel
def mean_of_flows(
    first: int, last: int, raster: Raster, own: Pairs, others: tuple[Pairs, ...], count: int, paths: Path, mean: Array
) -> None:
    """Write the mean of a flow, as :func:`mean_of_planes` does: the major eigenvector of the mean tensor t t^T.

    A tensor is held by its double angle, (t_x^2 - t_y^2, 2 t_x t_y), which has no sign. ``mean`` is (H x stride x 2,);
    its tangents have the sign of the own ones.
    """
    stride = raster.stride
    size = (last - first) * stride
    paths, pictures = addresses(paths), _addresses_of(others)
    for y in range(first, last):
        for x0 in range(0, stride, LANES):
            x = min(x0, stride - LANES)
            pixel, at = y * stride + x, (y - first) * stride + x
            tx, ty = load_pairs(own, pixel)
            cosine, sine = _double(tx, ty)
            c = s = splat_floats(0.0)
            weights = splat_floats(1.0)
            for k in range(count):
                place, weight = place_of(paths, k * size + at, raster), load(paths.weight, k * size + at)
                there_c, there_s = _sample_double(pictures[k], place)
                c, s = c + weight * (there_c - cosine), s + weight * (there_s - sine)
                weights = weights + weight
            same = (c == 0.0) & (s == 0.0)
            ux, uy = _halved(cosine + c / weights, sine + s / weights, tx, ty)
            store_pairs(mean, 2 * pixel, (select(same, tx, ux), select(same, ty, uy)))


@inlined
def _double(x: Floats, y: Floats) -> tuple[Floats, Floats]:
    """Return the double angle of tangents."""
    return x * x - y * y, 2.0 * x * y


@inlined
def _sample_double(flow: Pairs, at: Place) -> tuple[Floats, Floats]:
    """Return the double angle of a flow at the places."""
    ax, ay, bx, by, cx, cy, dx, dy = corner_pairs(flow, at)
    a, b, c, d = _double(ax, ay), _double(bx, by), _double(cx, cy), _double(dx, dy)
    return mix4(a[0], b[0], c[0], d[0], at), mix4(a[1], b[1], c[1], d[1], at)


@inlined
def _halved(cosine: Floats, sine: Floats, tx: Floats, ty: Floats) -> tuple[Floats, Floats]:
    """Return the unit tangents of double angles, turned to agree with (tx, ty), which stay where there is no angle."""
    length = sqrt(cosine * cosine + sine * sine)
    large = sqrt(0.5 + 0.5 * absolute(cosine) / length)  # the larger of |u_x| and |u_y|
    small = 0.5 * sine / (length * large)
    flat = cosine >= 0.0
    x, y = select(flat, large, small), select(flat, small, large)
    against = x * tx + y * ty < 0.0
    found = length > 0.0
    return select(found, select(against, -x, x), tx), select(found, select(against, -y, y), ty)
