"""Means over a window of frames, along the way that each pixel's surface goes: steady, and without recursion.

A frame needs the frames around it and no result of another one, so that any of them can be made first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FALLOFFS
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.motion.convention import Steps
from flowabs_nodes.filters.motion.following import Limits, go_on, judge, set_out
from flowabs_nodes.filters.motion.misfit import Misfit, measure_misfit
from flowabs_nodes.filters.motion.places import Pairs, Path, rows_of_triples
from flowabs_nodes.filters.motion.window_frames import (
    Frame,
    Frames,
    check_by_offset,
    checked_alphas,
    checked_pictures,
    frames_of,
    window_offsets,
)
from flowabs_nodes.filters.motion.window_mean import MOST, mean_of_colors, mean_of_flows, mean_of_planes
from flowabs_nodes.filters.regions.range_weights import as_records
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.read_only import for_kernel

_AT_ONCE = 2**15  # pixels in a band at most: their paths stay in the processor's cache


class WindowMean(NamedTuple):
    """What a window gives.

    Attributes
    ----------
    mean
        Of the shape of the own frame's picture, float32.
    confidence
        (H, W) float32, 0 to 1: the share of the weight that the other frames of the window could have. 0 where the
        pixel is its own frame's alone.
    misfit
        How well frames -1 and 1 fit along the motion; None without a guide, or where no pixel moves.
    """

    mean: Array
    confidence: Array
    misfit: Misfit | None


def motion_window(
    images: Frames,
    motions: Frames,
    guides: Frames | None = None,
    depths: Frames | None = None,
    normals: Frames | None = None,
    alphas: Frames | None = None,
    reach: int = 2,
    falloff: str = "gaussian",
    agreement: float = 8.0,
    guide_blur: float = 2.0,
    consistency: float = 1.0,
    depth_tolerance: float = 0.05,
    normal_tolerance: float = 26.0,
) -> WindowMean:
    """Average each pixel over the frames around it, along its motion, where they agree.

    Motion is followed from frame to frame: the place two frames away is where the motion of the frame between leads.
    The window ends, on each side, before the first frame that any of the inputs lacks.

    Parameters
    ----------
    images
        By offset: (H, W), one channel; (H, W, 2), a flow, whose tensors are averaged; or (H, W, 3), code values, not
        multiplied by alpha.
    motions
        By offset: (H, W, 4), motion passes (:mod:`~flowabs_nodes.filters.motion.convention`). A vector that is NaN, or
        leads out of the picture, leads nowhere: the pixel keeps to its own frame on that side.
    guides
        By offset: code values (H, W) that say whether frames agree. None: they always do.
    depths
        By offset: distances (H, W); 1e9 and more, Inf and NaN are background. Silhouettes, whose motion mixes two
        surfaces, take the nearest pure pixel's.
    normals
        By offset: (H, W, 3), of any one space; (0, 0, 0) goes with every other. None: not compared.
    alphas
        By offset: coverage (H, W) of code values, which count as far as they cover. None is 1 everywhere.
    reach
        How many frames before and after are looked at, 0 to 4; 0 gives a copy.
    falloff
        Weight of a frame k away: "gaussian", exp(-k^2 / (2 reach^2)), or "box", 1.
    agreement
        Sigma, in code values above 0, of the weight for a change of the guide.
    guide_blur
        Sigma of a Gaussian blur of the guide before, in pixels, 0 to 10,000: noise is no change.
    consistency
        How far from where it started a pixel may come back, one frame there and back, in pixels, at least 0.
    depth_tolerance
        How much the depth may change, for each frame of the way, as a part of the nearer one, at least 0.
    normal_tolerance
        How far the normal may turn, in degrees, 0 to 180.

    Returns
    -------
    The mean, the confidence, and how well frames fit along the motion: a :class:`WindowMean`.

    Raises
    ------
    ArgumentError
        For another shape, size or dtype, pixels other than of ``motions``, ``depths`` and ``normals`` that are not
        finite, or a parameter out of range.
    """
    reach = validate.whole("reach", reach, min=0, max=MOST // 2)
    validate.choice("falloff", falloff, FALLOFFS)
    agreement = validate.number("agreement", agreement, above=0)
    guide_blur = validate.number("guide_blur", guide_blur, min=0, max=10_000)
    consistency = validate.number("consistency", consistency, min=0)
    depth_tolerance = validate.number("depth_tolerance", depth_tolerance, min=0)
    normal_tolerance = validate.number("normal_tolerance", normal_tolerance, min=0, max=180)
    check_by_offset(images=images, motions=motions, guides=guides, depths=depths, normals=normals, alphas=alphas)
    given = [each for each in (images, motions, guides, depths, normals, alphas) if each is not None]
    offsets = window_offsets(given, reach)
    pictures = checked_pictures(images, offsets)
    covered = checked_alphas(alphas, pictures)
    raster = raster_of(pictures[0])
    frames = frames_of(motions, guides, depths, normals, guide_blur, offsets, raster)

    def weight(k: int) -> float:
        """Return g(k)."""
        return math.exp(-k * k / (2 * reach * reach)) if falloff == "gaussian" else 1.0

    limits = {
        k: Limits(
            consistency=consistency,
            depth=depth_tolerance * abs(k),
            cosine=math.cos(math.radians(normal_tolerance)),
            exponent=-math.log2(math.e) / (2 * agreement * agreement),
            falloff=weight(k),
        )
        for k in offsets
    }
    full = np.array([weight(k) for k in (*range(1, reach + 1), *range(1, reach + 1))], np.float32).sum()
    return _over_window(pictures, covered, frames, limits, full, raster)


# ---------------------------------------------------------------------- the window


def _over_window(
    pictures: Mapping[int, Array],
    alphas: Mapping[int, Array | None],
    frames: Mapping[int, Frame],
    limits: Mapping[int, Limits],
    full: np.float32,
    raster: Raster,
) -> WindowMean:
    """Return the result: paths are followed, and values averaged, some rows at a time.

    ``full`` is the weight that all other frames of a whole window have.
    """
    offsets = tuple(limits)
    frames = {k: for_kernel(frame) for k, frame in frames.items()}
    own, others, kernel = _ready(pictures, alphas, offsets, raster)
    seen = frames[0].seen
    mean = np.empty((raster.height, raster.stride, *pictures[0].shape[2:]), np.float32)
    confidence = np.zeros((raster.height, raster.stride), np.float32)
    misfits = np.zeros((2, raster.height, 3))

    def average(first: int, last: int) -> None:
        """Make the rows ``first`` .. ``last`` - 1."""
        size = (last - first) * raster.stride
        start, paths = _at_home(size), _new_paths(len(offsets) * size)
        before = start
        for at, k in enumerate(offsets):
            there, after = frames[k], _part(paths, slice(at * size, (at + 1) * size))
            onward, back = _there_and_back(frames[k - 1 if k > 0 else k + 1].steps, there.steps, k)
            if abs(k) == 1:
                before = start
                set_out(first, last, raster, onward, after)
            else:
                go_on(first, last, raster, onward, before, after)
            judge(first, last, raster, back, seen, there.seen, limits[k], before, after)
            if abs(k) == 1 and seen.guide.size > 0:
                measure_misfit(first, last, raster, after, seen.guide, there.seen.guide, misfits[int(k > 0)])
            before = after
        kernel(first, last, raster, own, others, len(offsets), paths, mean.reshape(-1))
        if offsets:
            weights = paths.weight.reshape(len(offsets), last - first, raster.stride).sum(axis=0)
            np.minimum(weights / full, 1, out=confidence[first:last])

    over_rows(average, raster.height, least=1, most=max(1, _AT_ONCE // raster.stride))
    cut = (slice(None), slice(raster.width))
    misfit = Misfit.of(misfits, raster.width * raster.height)
    return WindowMean(np.ascontiguousarray(mean[cut]), np.ascontiguousarray(confidence[cut]), misfit)


def _ready(
    pictures: Mapping[int, Array], alphas: Mapping[int, Array | None], offsets: tuple[int, ...], raster: Raster
) -> tuple[Array, tuple[Array, ...], Callable[..., None]]:
    """Return the own picture, those of the other frames, and the kernel that averages them.

    There are always ``MOST`` others, so that kernels are compiled once: after those of ``offsets`` the own one again.
    """
    kernel: Callable[..., None]
    if pictures[0].shape[2:] == (3,):
        ready = {k: _records(picture, alphas[k], raster) for k, picture in pictures.items()}
        kernel = partial(_mean_of_colors, None if alphas[0] is None else True)
    else:
        ready = {k: padded_rows(picture, raster) for k, picture in pictures.items()}
        kernel = mean_of_planes
    if pictures[0].shape[2:] == (2,):
        ready = {k: picture.view(np.complex64) for k, picture in ready.items()}
        kernel = mean_of_flows
    ready = {k: for_kernel(picture) for k, picture in ready.items()}
    others = [ready[k] for k in offsets] + [ready[0]] * (MOST - len(offsets))
    return ready[0], tuple(others), kernel


def _records(picture: Array, alpha: Array | None, raster: Raster) -> Array:
    """Return colours, and alpha if there is one, as :func:`mean_of_colors` reads them."""
    return rows_of_triples(picture, raster) if alpha is None else as_records(picture, alpha, raster)


def _mean_of_colors(alpha: bool | None, *arguments: Any) -> None:
    mean_of_colors(*arguments, alpha)


def _new_paths(size: int) -> Path:
    """Return memory for the paths of ``size`` pixels."""
    dx, dy, fx, fy, weight = np.empty((5, size), np.float32)
    return Path(dx, dy, np.empty(size, np.int32), fx, fy, weight)


def _at_home(size: int) -> Path:
    """Return paths of ``size`` pixels that have not set out: of them only the offsets are there."""
    nowhere, nothing = np.zeros(size, np.float32), np.empty(0, np.float32)
    return Path(nowhere, nowhere, np.empty(0, np.int32), nothing, nothing, nothing)


def _part(paths: Path, part: slice) -> Path:
    """Return some of the paths."""
    dx, dy, corner, fx, fy, weight = paths
    return Path(dx[part], dy[part], corner[part], fx[part], fy[part], weight[part])


def _there_and_back(near: Steps, far: Steps, k: int) -> tuple[Pairs, Pairs]:
    """Return the steps from the nearer frame to the one at offset k, and from there back."""
    return (near.following, far.previous) if k > 0 else (near.previous, far.following)
