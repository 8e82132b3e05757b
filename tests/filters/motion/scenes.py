"""A drawn moving picture, exact at any time: a textured disc that goes by in front of a textured ground."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float32]

GROUND, DISC = 10.0, 4.0  # their depths


@dataclass(frozen=True)
class Scene:
    """The scene: velocities are in pixels a frame, x to the right and y down; both disc and ground are stuck together
    with their textures."""

    width: int = 45
    height: int = 33
    ground: tuple[float, float] = (1.0, 2.0)
    disc: tuple[float, float] = (-2.0, 1.0)
    radius: float = 8.0

    def coords(self) -> tuple[Array, Array]:
        y, x = np.mgrid[: self.height, : self.width].astype(np.float64)
        return x, y

    def covered(self, frame: int) -> npt.NDArray[np.bool_]:
        """Return where the disc is on a frame; on frame 0 it is in the middle."""
        x, y = self.coords()
        cx, cy = self.width / 2 + frame * self.disc[0], self.height / 2 + frame * self.disc[1]
        return np.hypot(x - cx, y - cy) < self.radius

    def texture(self, frame: int, velocity: tuple[float, float], seed: int) -> Array:
        """Return waves, 0 to 255, that move along: (H, W, 3)."""
        x, y = self.coords()
        x, y = x - frame * velocity[0], y - frame * velocity[1]
        turn = np.random.default_rng(seed)
        waves = []
        for _ in range(3):
            a, b, c, d = turn.uniform(0.3, 0.8, 4)
            waves.append(127 + 60 * np.sin(a * x + b * y) + 60 * np.cos(c * x - d * y))
        return np.stack(waves, axis=2)

    def codes(self, frame: int) -> Array:
        """Return code values, (H, W, 3)."""
        where = self.covered(frame)[..., None]
        picture = np.where(where, self.texture(frame, self.disc, 1), self.texture(frame, self.ground, 2))
        return picture.astype(np.float32)

    def motion(self, frame: int) -> Array:
        """Return the motion pass, (H, W, 4), y up: X, Y to the place before; the place after is at -Z, -W."""
        vx, vy = (np.where(self.covered(frame), *pair) for pair in zip(self.disc, self.ground, strict=True))
        return np.stack([-vx, vy, -vx, vy], axis=2).astype(np.float32)

    def depth(self, frame: int) -> Array:
        return np.where(self.covered(frame), np.float32(DISC), np.float32(GROUND))

    def normal(self, frame: int) -> Array:
        up, slanted = np.float32([0, 0, 1]), np.float32([0.8, 0, 0.6])
        return np.where(self.covered(frame)[..., None], slanted, up)

    def flow(self, frame: int) -> Array:
        """Return unit tangents, (H, W, 2), whose sign changes from pixel to pixel."""
        picture = self.codes(frame).astype(np.float64)
        angle = picture[..., 0] / 100
        sign = np.where(np.indices(angle.shape).sum(axis=0) % 2, 1, -1)
        return np.stack([sign * np.cos(angle), sign * np.sin(angle)], axis=2).astype(np.float32)

    def alpha(self, frame: int) -> Array:
        return (self.codes(frame)[..., 1] / 300).clip(0, 1)

    def frames(self, what: str, offsets: Iterable[int] = range(-2, 3)) -> dict[int, Array]:
        """Return "codes", "motion", "depth" ... by frame; "code" is the first of the codes."""
        if what == "code":
            return {k: np.ascontiguousarray(self.codes(k)[..., 0]) for k in offsets}
        return {k: getattr(self, what)(k) for k in offsets}
