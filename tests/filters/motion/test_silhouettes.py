"""Where the motion of a silhouette's pixels comes from."""

import numpy as np
import pytest

from flowabs_nodes.filters.motion.convention import steps_of
from flowabs_nodes.filters.motion.silhouettes import with_pure_motion
from flowabs_nodes.sampling.coords import padded_rows, raster_of
from tests.filters.motion.scenes import Scene
from tests.naive.motion_window import pure_motion


def pure(motion, depth):
    """Return the motion pass with what the filter makes of its steps."""
    raster = raster_of(motion)
    steps = with_pure_motion(steps_of(motion, raster), padded_rows(depth, raster), raster)
    x, y = (each.view(np.float32).reshape(raster.height, raster.stride, 2) for each in steps)
    return np.concatenate([x * [1, -1], y * [-1, 1]], axis=2)[:, : raster.width].astype(np.float32)


def test_each_side_of_a_silhouette_moves_as_its_surface_does():
    scene = Scene()
    covered, motion = scene.covered(0), scene.motion(0)
    edge = np.zeros_like(covered)
    for axis in (0, 1):
        for shift in (-1, 1):
            edge |= covered != np.roll(covered, shift, axis)
    filtered = motion.copy()
    filtered[edge] = motion.mean(axis=(0, 1))  # neither one's nor the other's
    assert np.array_equal(pure(filtered, scene.depth(0)), motion)


def test_a_slanted_plane_has_no_silhouettes():
    depth = (10 + 0.2 * np.mgrid[:20, :30][1]).astype(np.float32)
    motion = np.random.default_rng(1).normal(size=(20, 30, 4)).astype(np.float32)
    assert np.array_equal(pure(motion, depth), motion)


@pytest.mark.parametrize("shape", [(30, 40), (9, 5), (1, 20), (20, 1)])
def test_is_the_naive_search(shape):
    random = np.random.default_rng(2)
    depth = np.where(random.random(shape) < 0.1, random.uniform(1, 20, shape), 10).astype(np.float32)
    depth[random.random(shape) < 0.02] = 1e10
    motion = random.normal(size=(*shape, 4)).astype(np.float32)
    assert np.array_equal(pure(motion, depth), pure_motion(motion, depth).astype(np.float32))
