"""The frames that a window is made from: which there are, checked, and made ready to be followed through."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import validate
from flowabs_nodes.filters.gaussian_blur import blur
from flowabs_nodes.filters.motion.convention import Steps, steps_of
from flowabs_nodes.filters.motion.following import Seen
from flowabs_nodes.filters.motion.places import rows_of_triples
from flowabs_nodes.filters.motion.silhouettes import with_pure_motion
from flowabs_nodes.sampling.coords import Raster, padded_rows

#: Pictures by the offset of their frame from the one that is made, 0 among them.
Frames = Mapping[int, npt.ArrayLike]

_NOTHING = np.empty(0, np.float32)


class Frame(NamedTuple):
    """A frame of the window: where its pixels go, and what is seen on it."""

    steps: Steps
    seen: Seen


def check_by_offset(**inputs: Any) -> None:
    """Raise ArgumentError for an input that is no mapping from offsets to pictures; None is no input."""
    for name, frames in inputs.items():
        if frames is not None and not isinstance(frames, Mapping):
            found = type(frames).__name__
            message = f"{name}: expected pictures by their offset, {{-1: .., 0: .., 1: ..}}, found {found}"
            raise ArgumentError(message, code="wrong-type", parameter=name)


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


def checked_pictures(images: Frames, offsets: Sequence[int]) -> dict[int, Array]:
    """Return the pictures of the own frame and of those at ``offsets``, all of one shape."""
    if 0 not in images:
        found = ", ".join(map(str, images)) or "none"
        raise ArgumentError(f"images: expected the own frame, 0, among the offsets, found {found}", parameter="images")
    pictures = {k: validate.any_channels("images", images[k], summed=True) for k in (0, *offsets)}
    shape = pictures[0].shape
    if len(shape) == 3 and shape[2] not in (2, 3):
        expected = "(H, W), (H, W, 2) or (H, W, 3)"
        raise ArgumentError(f"images: expected shape {expected}, found {shape}", parameter="images")
    for k, picture in pictures.items():
        if picture.shape != shape:
            found = f"{picture.shape} on frame {k:+d}"
            raise ArgumentError(f"images: expected shape {shape}, as on frame 0, found {found}", parameter="images")
    return pictures


def checked_alphas(alphas: Frames | None, pictures: Mapping[int, Array]) -> dict[int, Array | None]:
    """Return the coverage (H, W) of each picture, None where there is none."""
    if alphas is None:
        return dict.fromkeys(pictures)
    if pictures[0].shape[2:] != (3,):
        message = f"alphas: expected for code values (H, W, 3) alone, found images {pictures[0].shape}"
        raise ArgumentError(message, parameter="alphas")
    planes = {k: validate.plane("alphas", alphas.get(k, _NOTHING), picture.shape) for k, picture in pictures.items()}
    return {k: np.maximum(plane, 0) for k, plane in planes.items()}


def frames_of(
    motions: Frames,
    guides: Frames | None,
    depths: Frames | None,
    normals: Frames | None,
    guide_blur: float,
    offsets: Sequence[int],
    raster: Raster,
) -> dict[int, Frame]:
    """Return the own frame and those at ``offsets``; of guides, depths and normals there may be none."""
    frames = {}
    first, last = min((0, *offsets)), max((0, *offsets))
    for k in (0, *offsets):
        motion = _channels("motions", motions, k, 4, raster)
        # The last frame leads back alone, the first one on.
        steps = steps_of(motion, raster, previous=k > first, following=k < last)
        depth = normal = guide = _NOTHING
        if depths is not None:
            depth = _plane("depths", depths, k, raster, check_finite=False)
            steps = with_pure_motion(steps, depth, raster)
        if normals is not None:
            normal = rows_of_triples(_channels("normals", normals, k, 3, raster), raster)
        if guides is not None:
            guide = _plane("guides", guides, k, raster, sigma=guide_blur)
        frames[k] = Frame(steps, Seen(guide, depth, normal))
    return frames


def _plane(
    name: str, frames: Frames, k: int, raster: Raster, *, sigma: float = 0.0, check_finite: bool = True
) -> Array:
    """Return numbers (H, W) of a frame, blurred with ``sigma`` and flattened."""
    shape = (raster.height, raster.width)
    plane = validate.plane(name, frames.get(k, _NOTHING), shape, check_finite=check_finite)
    return padded_rows(blur(plane, sigma) if sigma > 0 else plane, raster)


def _channels(name: str, frames: Frames, k: int, count: int, raster: Raster) -> Array:
    """Return numbers (H, W, count) of a frame, which need not be finite."""
    array = validate.any_channels(name, frames.get(k, _NOTHING), check_finite=False)
    expected = (raster.height, raster.width, count)
    if array.shape != expected:
        raise ArgumentError(f"{name}: expected shape {expected}, found {array.shape} on frame {k:+d}", parameter=name)
    return array
