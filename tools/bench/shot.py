"""Make the passes of a shot to measure on: spheres over a floor that reaches to the horizon, all moving alike."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes import filters
from flowabs_nodes.filters.background import FAR
from tools.bench.scene import Array

_REACH = 2  # frames before and after
_STEP = (3, 1)  # pixels to the right and down from frame to frame
_SPHERES_PER_PIXEL = 1 / 16_000
_EYE = 2.0  # height of the camera, in its distance from the screen


class Shot:
    """Passes of one frame, and the pictures around it, each computed on first use; ``rgb`` is (H, W, 3)."""

    def __init__(self, rgb: Array) -> None:
        self.rgb = rgb

    @cached_property
    def _surfaces(self) -> tuple[Array, Array, npt.NDArray[np.uint32]]:
        """Return depth, normals and ids: at each pixel those of the nearest surface."""
        height, width, _ = self.rgb.shape
        y, x = np.mgrid[:height, :width].astype(np.float32)
        down = (y - 0.4 * height) / np.float32(height)  # of the ray, 0 at the horizon
        floor = down > 0.01
        depth = np.where(floor, _EYE / np.maximum(down, np.float32(0.01)), np.float32(FAR))
        normal = np.zeros((height, width, 3), np.float32)
        normal[floor] = (0, 1, 0)
        ids = floor.astype(np.uint32)
        random = np.random.default_rng(2009)
        for sphere in range(max(2, round(height * width * _SPHERES_PER_PIXEL))):
            radius = height * (0.02 + 0.08 * random.random())
            u, v = (x - width * random.random()) / radius, (y - height * random.random()) / radius
            toward = np.sqrt(np.maximum(1 - u * u - v * v, 0))
            near = (toward > 0) & ((z := 4 + 40 * random.random() - toward) < depth)
            depth, ids = np.where(near, z, depth), np.where(near, np.uint32(sphere + 2), ids)
            normal[near] = np.stack([u, -v, toward], axis=2)[near]
        return depth.astype(np.float32), normal, ids

    @cached_property
    def passes(self) -> dict[str, Any]:
        """Return depth, normals and ids, by the names that filters know."""
        return dict(zip(("depth", "normal", "id"), self._surfaces, strict=True))

    @cached_property
    def edges(self) -> Any:
        """Return all that ``aov_lines`` makes of the passes."""
        return filters.aov_lines(**self.passes)

    @cached_property
    def mattes(self) -> dict[str, Array]:
        return {kind: getattr(self.edges, kind) for kind in ("outline", "object", "material", "crease", "intersection")}

    @cached_property
    def window(self) -> dict[str, Any]:
        """Return what ``motion_window`` reads by offset: pictures, motion, guides, depths and normals."""
        depth, normal, _ = self._surfaces
        dx, dy = _STEP
        motion = np.empty((*depth.shape, 4), np.float32)
        motion[:] = (-dx, dy, -dx, dy)  # y up: previous = (x + X, y - Y), next = (x - Z, y + W)
        codes = np.clip(255 * self.rgb, 0, 255)
        every = {"images": codes, "guides": codes[..., 0], "depths": depth, "normals": normal}
        offsets = range(-_REACH, _REACH + 1)
        frames = {
            name: {k: np.ascontiguousarray(np.roll(each, (k * dy, k * dx), (0, 1))) for k in offsets}
            for name, each in every.items()
        }
        return frames | {"motions": dict.fromkeys(offsets, motion)}

    def window_of(self, *names: str) -> dict[str, Any]:
        """Return some of what ``window`` has."""
        return {name: self.window[name] for name in names}
