import numpy as np
import pytest

from flowabs_nodes.filters.motion.convention import lost_pixels, motion_of, steps_of
from flowabs_nodes.sampling.coords import raster_of


@pytest.mark.parametrize("shape", [(5, 20), (3, 16), (4, 7), (1, 1)])
def test_a_motion_pass_leads_right_and_down(shape):
    motion = np.empty((*shape, 4), np.float32)
    motion[:] = (-3, 2, 5, 7)  # y up: before it was 3 to the left and 2 above; then it is 5 to the left and 7 below
    raster = raster_of(motion)
    for step, expected in zip(steps_of(motion, raster), ((-3, -2), (-5, 7)), strict=True):
        found = step.reshape(raster.height, raster.stride)[:, : raster.width]
        assert (found == complex(*expected)).all()


def test_there_and_back_it_is_the_same_pass():
    motion = np.random.default_rng(1).normal(size=(6, 20, 4)).astype(np.float32)
    steps = [each.view(np.float32).reshape(6, 20, 2) for each in steps_of(motion, raster_of(motion))]
    assert np.array_equal(motion_of(*steps), motion)


def test_vectors_that_lead_nowhere_are_counted():
    motion = np.zeros((6, 7, 4), np.float32)
    assert lost_pixels(motion) == 0
    motion[0, 0, 0], motion[1, 1, 3], motion[2, 2, 1], motion[3, 3] = np.nan, np.inf, -1e9, 1e10
    motion[4, 4] = 60_000
    assert lost_pixels(motion) == 4
