"""Means over a window of frames, along the way that each pixel's surface goes: steady, and without recursion.

A frame needs the frames around it and no result of another one, so that any of them can be made first.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FALLOFFS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.motion.convention import Steps, steps_of
from flowabs_nodes.filters.motion.following import Limits, Seen, begin_paths, follow
from flowabs_nodes.filters.motion.misfit import Misfit, measure_misfit
from flowabs_nodes.filters.motion.places import Pairs, Path
from flowabs_nodes.filters.motion.silhouettes import with_pure_motion
from flowabs_nodes.filters.motion.surface import known_depths, surfaces
from flowabs_nodes.filters.motion.window_mean import MOST, mean_of_colors, mean_of_flows, mean_of_planes
from flowabs_nodes.filters.regions.range_weights import as_records
from flowabs_nodes.sampling.coords import Raster, padded_rows, raster_of
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.read_only import for_kernel

#: Pictures by the offset of their frame from the one that is made, 0 among them.
Frames = Mapping[int, npt.ArrayLike]

_ROWS = 16  # in a band at most: its paths stay in the processor's cache
_NOTHING = np.empty(0, np.float32)


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
        By offset: coverage (H, W) of code values: each counts as far as it covers. None is 1 everywhere.
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
    given = [each for each in (images, motions, guides, depths, normals, alphas) if each is not None]
    offsets = window_offsets(given, reach)
    pictures = {k: _picture(images, k) for k in (0, *offsets)}
    raster = raster_of(pictures[0])

    def weight(k: int) -> float:
        """Return g(k)."""
        return math.exp(-k * k / (2 * reach * reach)) if falloff == "gaussian" and k else 1.0

    frames = {}
    for k in (0, *offsets):
        depth = known_depths(_plane("depths", depths, k, raster), raster.stride)
        steps = steps_of(_channels("motions", motions, k, raster, 4), raster)
        frames[k] = _Frame(
            with_pure_motion(steps, depth, raster) if depth.size > 0 else steps,
            Seen(_guide(guides, k, guide_blur, raster), surfaces(_normal(normals, k, raster), depth, raster.stride)),
            Limits(
                consistency=consistency,
                depth=depth_tolerance * abs(k),
                cosine=math.cos(math.radians(normal_tolerance)),
                exponent=-math.log2(math.e) / (2 * agreement * agreement),
                falloff=weight(k),
            ),
        )
    full = np.array([weight(k) for k in (*range(1, reach + 1), *range(1, reach + 1))], np.float32).sum()
    covered = None if alphas is None else {k: _alpha(alphas, k, raster) for k in (0, *offsets)}
    mean, confidence, misfit = _over_window(pictures, covered, frames, full, raster)
    return WindowMean(mean, confidence, misfit)


def window_offsets(given: Sequence[Mapping[int, Any]], reach: int) -> tuple[int, ...]:
    """Return the offsets, but for 0, of the frames that every one of the ``given`` inputs has: 1, 2 .., then -1, -2 ..

    A frame that any of them lacks ends the window on its side: motion leads from each frame to the next one alone.
    """
    found: list[int] = []
    for side in (1, -1):
        for k in range(1, reach + 1):
            if not all(side * k in frames for frames in given):
                break
            found.append(side * k)
    return tuple(found)


# ---------------------------------------------------------------------- what is given, checked


class _Frame(NamedTuple):
    """A frame of the window: where its pixels go, what is seen on it, and what is asked of places on it."""

    steps: Steps
    seen: Seen
    limits: Limits


def _picture(images: Frames, k: int) -> Array:
    """Return the picture of a frame, checked, of the shape of the own one."""
    if 0 not in images:
        found = ", ".join(map(str, images)) or "none"
        raise ArgumentError(f"images: expected the own frame, 0, among the offsets, found {found}", parameter="images")
    picture = validate.any_channels("images", images[k], summed=True)
    shape = np.shape(images[0])
    if picture.ndim == 3 and picture.shape[2] not in (2, 3):
        expected = "(H, W), (H, W, 2) or (H, W, 3)"
        raise ArgumentError(f"images: expected shape {expected}, found {picture.shape}", parameter="images")
    if picture.shape != shape:
        found = f"{picture.shape} on frame {k:+d}"
        raise ArgumentError(f"images: expected shape {shape}, as on frame 0, found {found}", parameter="images")
    return picture


def _channels(name: str, frames: Frames, k: int, raster: Raster, count: int) -> Array:
    """Return numbers (H, W, count) of a frame, which need not be finite."""
    array = validate.any_channels(name, frames.get(k, _NOTHING), check_finite=False)
    expected = (raster.height, raster.width, count)
    if array.shape != expected:
        raise ArgumentError(f"{name}: expected shape {expected}, found {array.shape} on frame {k:+d}", parameter=name)
    return array


def _plane(name: str, frames: Frames | None, k: int, raster: Raster, *, check_finite: bool = False) -> Array:
    """Return numbers (H, W) of a frame, flattened; nothing where there are no ``frames``."""
    if frames is None:
        return _NOTHING
    shape = (raster.height, raster.width)
    return padded_rows(validate.plane(name, frames.get(k, _NOTHING), shape, check_finite=check_finite), raster)


def _normal(normals: Frames | None, k: int, raster: Raster) -> Array:
    """Return the normals of a frame, flattened; nothing where there are none."""
    return _NOTHING if normals is None else padded_rows(_channels("normals", normals, k, raster, 3), raster)


def _guide(guides: Frames | None, k: int, sigma: float, raster: Raster) -> Array:
    """Return the guide of a frame, blurred and flattened; nothing where there is none."""
    if guides is None:
        return _NOTHING
    guide = validate.plane("guides", guides.get(k, _NOTHING), (raster.height, raster.width))
    return padded_rows(blur(guide, sigma) if sigma > 0 else guide, raster)


def _alpha(alphas: Frames, k: int, raster: Raster) -> Array:
    """Return the coverage of a frame."""
    return validate.plane("alphas", alphas.get(k, _NOTHING), (raster.height, raster.width))


# ---------------------------------------------------------------------- the window


def _over_window(
    pictures: Mapping[int, Array],
    alphas: Mapping[int, Array] | None,
    frames: Mapping[int, _Frame],
    full: np.float32,
    raster: Raster,
) -> tuple[Array, Array, Misfit | None]:
    """Return mean, confidence and misfit: paths are followed, and values averaged, some rows at a time.

    ``full`` is the weight that all other frames of a whole window have.
    """
    offsets = tuple(k for k in frames if k != 0)
    frames = {k: for_kernel(frame) for k, frame in frames.items()}
    own, others, kernel = _ready(pictures, alphas, offsets, raster)
    seen = frames[0].seen
    mean = np.empty((raster.height, raster.stride, *pictures[0].shape[2:]), np.float32)
    confidence = np.zeros((raster.height, raster.stride), np.float32)
    misfits = np.zeros((2, raster.height, 3))

    def average(first: int, last: int) -> None:
        """Make the rows ``first`` .. ``last`` - 1."""
        size = (last - first) * raster.stride
        start, paths = _new_paths(1, size), _new_paths(len(offsets), size)
        begin_paths(first, last, raster, start)
        before = start
        for at, k in enumerate(offsets):
            there, after = frames[k], _part(paths, slice(at * size, (at + 1) * size))
            if abs(k) == 1:
                before = start
            steps = _there_and_back(frames[k - 1 if k > 0 else k + 1].steps, there.steps, k)
            follow(first, last, raster, steps, seen, there.seen, there.limits, before, after)
            if abs(k) == 1 and seen.guide.size > 0:
                measure_misfit(first, last, raster, after, seen.guide, there.seen.guide, misfits[int(k > 0)])
            before = after
        kernel(first, last, raster, own, others, len(offsets), paths, mean.reshape(-1))
        if offsets:
            weights = paths.weight.reshape(len(offsets), last - first, raster.stride).sum(axis=0)
            np.minimum(weights / full, 1, out=confidence[first:last])

    over_rows(average, raster.height, least=1, most=_ROWS)
    cut = (slice(None), slice(raster.width))
    misfit = Misfit.of(misfits, raster.width * raster.height)
    return np.ascontiguousarray(mean[cut]), np.ascontiguousarray(confidence[cut]), misfit


def _ready(
    pictures: Mapping[int, Array], alphas: Mapping[int, Array] | None, offsets: tuple[int, ...], raster: Raster
) -> tuple[Array, tuple[Array, ...], Callable[..., None]]:
    """Return the own picture, those of the other frames, and the kernel that averages them.

    There are always ``MOST`` others, so that kernels are compiled once: after those of ``offsets`` the own one again.
    """
    kernel: Callable[..., None]
    if pictures[0].ndim == 2:
        ready = {k: padded_rows(picture, raster) for k, picture in pictures.items()}
        kernel = mean_of_planes
    elif pictures[0].shape[2] == 2:
        ready = {k: padded_rows(picture, raster).view(np.complex64) for k, picture in pictures.items()}
        kernel = mean_of_flows
    else:
        ready = {
            k: as_records(picture, None if alphas is None else alphas[k], raster) for k, picture in pictures.items()
        }
        kernel = partial(_mean_of_colors, None if alphas is None else True)
    ready = {k: for_kernel(picture) for k, picture in ready.items()}
    others = [ready[k] for k in offsets] + [ready[0]] * (MOST - len(offsets))
    return ready[0], tuple(others), kernel


def _mean_of_colors(alpha: bool | None, *arguments: Any) -> None:
    mean_of_colors(*arguments, alpha)


def _new_paths(count: int, size: int) -> Path:
    """Return memory for the paths of ``size`` pixels to ``count`` frames."""
    dx, dy, fx, fy, weight = np.empty((5, count * size), np.float32)
    return Path(dx, dy, np.empty(count * size, np.int32), fx, fy, weight)


def _part(paths: Path, part: slice) -> Path:
    """Return some of the paths."""
    dx, dy, corner, fx, fy, weight = paths
    return Path(dx[part], dy[part], corner[part], fx[part], fy[part], weight[part])


def _there_and_back(near: Steps, far: Steps, k: int) -> tuple[Pairs, Pairs]:
    """Return the steps from the nearer frame to the one at offset k, and from there back."""
    return (near.following, far.previous) if k > 0 else (near.previous, far.following)
