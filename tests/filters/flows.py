"""Flows that the filters are tested on."""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt

from flowabs_nodes import filters
from tests.filters.pictures import noise, photo

#: Shapes (H, W) of pictures that streamlines leave at once.
THIN = [(1, 1), (1, 23), (23, 1), (2, 2), (2, 300)]


def random_flow(shape: tuple[int, ...], seed: int = 0, zeros: float = 0.1) -> npt.NDArray[np.float32]:
    """Return unit tangents in random directions, (H, W, 2), a share ``zeros`` of them zero."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0, 2 * np.pi, shape[:2])
    flow = np.stack([np.cos(angle), np.sin(angle)], -1)
    flow[random.random(shape[:2]) < zeros] = 0
    return flow.astype(np.float32)


@functools.cache
def cases() -> dict[str, tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]]:
    """Return code values (H, W, 3) and a flow by name: a photograph with its own flow, and noise with a random flow."""
    cat, plane = photo(), noise()
    return {
        "photo": (cat, filters.etf(cat[..., 0])),
        "noise": (np.stack([plane, plane[::-1], plane[:, ::-1]], -1), random_flow(plane.shape)),
    }


@functools.cache
def large() -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return code values (H, W) and a flow that turns slowly: several tiles, the last ones not whole."""
    y, x = np.mgrid[:150, :291]
    angle = 3 * np.sin(x / 40) + 2 * np.cos(y / 25) + 0.2 * random_flow((150, 291))[..., 0]
    return noise(150, 291), np.stack([np.cos(angle), np.sin(angle)], -1).astype(np.float32)
