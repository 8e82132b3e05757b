"""What tells surfaces apart from frame to frame: the depth and the normal of each pixel."""

from __future__ import annotations

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.background import BACKGROUND, FAR
from flowabs_nodes.filters.motion.places import Place, Triple, corner_triples
from flowabs_nodes.sampling.coords import Raster
from flowabs_nodes.simd.jit import inlined
from flowabs_nodes.simd.lanes import Floats, Masks, absolute, minimum, select, splat_floats, sqrt
from flowabs_nodes.simd.memory import address, gather_pairs, load, load_triples


@inlined
def known(z: Floats) -> Floats:
    """Return depths with one number, 1e10, for all that is background: from 1e9 on, Inf and NaN."""
    return select(z < BACKGROUND, z, splat_floats(FAR))


@inlined
def same_depth(depth: Array, there: Array, pixel: int, at: Place, tolerance: float) -> tuple[Masks, ...]:
    """Return where the four pixels around a place, (H x stride,), have the pixel's depth.

    They may differ by ``tolerance`` of the nearer one.
    """
    z = known(load(depth, pixel))
    a, b = gather_pairs(there, at.corner, at.at)
    c, d = gather_pairs(address(there, at.below), at.corner, at.at)
    return _near(z, a, tolerance), _near(z, b, tolerance), _near(z, c, tolerance), _near(z, d, tolerance)


@inlined
def same_normal(
    normal: Array, there: Array, pixel: int, records: Int32, k: int, cosine: float, raster: Raster
) -> tuple[Masks, ...]:
    """Return where the four pixels around a place, (H x stride x 3,), have the pixel's normal; (0, 0, 0) goes with any.

    ``records`` holds, from k on, where the normals of the upper left ones begin; ``cosine`` is the least between two.
    """
    n = load_triples(normal, 3 * pixel)
    a, b, c, d = corner_triples(there, records, k, raster)
    return _parallel(n, a, cosine), _parallel(n, b, cosine), _parallel(n, c, cosine), _parallel(n, d, cosine)


@inlined
def _near(z: Floats, there: Floats, tolerance: float) -> Masks:
    other = known(there)
    return absolute(other - z) <= tolerance * minimum(absolute(z), absolute(other))


@inlined
def _parallel(n: Triple, there: Triple, cosine: float) -> Masks:
    (u, v, w), (a, b, c) = n, there
    return u * a + v * b + w * c >= cosine * sqrt((u * u + v * v + w * w) * (a * a + b * b + c * c))
