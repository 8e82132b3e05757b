"""Motion in another convention fits worse than none; the right one fits better."""

import numpy as np
import pytest

from flowabs_nodes.filters import motion_window
from tests.filters.motion.scenes import Scene


def misfit(scene, channels=(0, 1, 2, 3), signs=(1, 1, 1, 1), noise=0.0, what="code"):
    random = np.random.default_rng(1)
    codes = {k: code + random.normal(0, noise, code.shape).astype(np.float32) for k, code in scene.frames(what).items()}
    motions = {k: motion[..., list(channels)] * np.float32(signs) for k, motion in scene.frames("motion").items()}
    return motion_window(codes, motions, codes, {k: scene.depth(k) for k in codes}).misfit


@pytest.mark.parametrize("noise", [0, 20])
def test_the_right_convention_fits(noise):
    found = misfit(Scene(), noise=noise)
    assert found.along < 0.5 * found.still
    assert not found.wrong


@pytest.mark.parametrize(
    ("channels", "signs"),
    [
        ((0, 1, 2, 3), (1, -1, 1, -1)),  # y down
        ((0, 1, 2, 3), (1, 1, -1, -1)),  # Z, W to the next frame: both ways lead to one side
        ((0, 1, 2, 3), (-1, -1, -1, -1)),  # forward for backward
        ((2, 3, 0, 1), (-1, -1, -1, -1)),
    ],
)
def test_another_convention_is_wrong(channels, signs):
    found = misfit(Scene(), channels, signs)
    assert found is None or found.wrong
