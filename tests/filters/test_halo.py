"""A halo holds every pixel that decides about a result, and no filter's halo is much larger than that.

That crops to a halo give the same bits is proved for every node by the compliance suite.
"""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.filters import halo

MIDDLE = 40
SIZE = 2 * MIDDLE + 1
EDGE = 50 * np.tanh((np.arange(SIZE)[:, None] - MIDDLE + 1) / 2)  # soft, along the level


@pytest.fixture(scope="module")
def noise():
    return np.random.default_rng(3).uniform(0, 255, (SIZE, SIZE, 3)).astype(np.float32)


def level(height, width):
    flow = np.zeros((height, width, 2), np.float32)
    flow[..., 0] = 1
    return flow


#: A filter of the code values (H, W, 3), its halo, and how many pixels of it this picture and flow leave unread.
CASES = {
    "blur": (lambda code: filters.blur(code, 2.1), halo.blur(2.1), 0),
    "dog": (lambda code: filters.dog(code[..., 0], 1.3), halo.dog(1.3), 0),
    "etf": (
        lambda code: filters.etf(code[..., 0], 5, 3, gradient_reference=16.0, fill=None, pre_blur=1.0),
        halo.etf(5, 3, 1.0),
        0,
    ),
    "bilateral": (lambda code: filters.bilateral(code, 2.0, 1000.0, 1), halo.bilateral(2.0, 1), 0),
    "quantize": (
        lambda code: filters.quantize(code[..., 0] / 2.55, by_gradient=1.0, gradient_length=1.7, hard_gradient=100.0),
        halo.quantize(1.0, 1.7),
        0,
    ),
    "rolling_guidance": (
        lambda code: filters.rolling_guidance(code, 2.0, 1000.0, 0),
        halo.rolling_guidance(2.0, 0),
        0,
    ),
    "flow_blur": (lambda code: filters.flow_blur(code, level(SIZE, SIZE), 3.0), halo.flow_blur(3.0), 1),
    "fdog": (lambda code: filters.fdog(code[..., 0], level(SIZE, SIZE), 3.0, 1.0), halo.flow_blur(3.0), 1),
    "fdog by evidence": (
        lambda code: filters.fdog(255 - code[..., 0], level(SIZE, SIZE), 2.0, 0.6, evidence=1.0),
        halo.flow_blur(2.0) + halo.flow_blur(6.0),
        2,
    ),
    "soft edges": (
        lambda code: filters.fdog(
            code[..., 0] / 50 + EDGE, level(SIZE, SIZE), 0.0, 1.0, soft_lines=1.0, soft_reach=4.0
        ),
        halo.flow_blur(2.0) + halo.blur(2.0),
        1,
    ),
    "fbl": (
        lambda code: filters.fbl(code, level(SIZE, SIZE), 2.0, 1000.0, 0.5, 1000.0, 1),  # the edge of 3 is below a bit
        halo.flow_blur(2.0),
        1,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_a_pixel_inside_the_halo_counts_and_one_outside_does_not(noise, name):
    run, pixels, unread = CASES[name]

    def changed(distance):
        """Change a column of pixels and say whether the pixel in the middle changes."""
        other = noise.copy()
        other[:, MIDDLE + distance] = 255 - other[:, MIDDLE + distance]
        return not np.array_equal(run(other)[MIDDLE, MIDDLE], run(noise)[MIDDLE, MIDDLE])

    assert changed(pixels - unread)
    assert not changed(pixels + 1)


def test_what_changes_nothing_has_no_halo():
    assert halo.blur(0) == halo.flow_blur(0) == halo.bilateral(2.0, 0) == halo.fbl(2.0, 0.5, 0) == 0
    assert halo.quantize(0.0, 2.0) == 0
    assert halo.etf(1.0, 3, 0.0) == halo.etf(0.0, 3, 0.0) == halo.etf(9.0, 0, 0.0) == 1  # the gradient alone


def test_passes_add_up():
    assert halo.fdog(3.0, 1.0) == 9 + 1 + 5 + 1
    assert (halo.evidence(3.0, 0.5), halo.evidence(3.0, 0)) == (27 + 1, 0)
    assert halo.rolling_guidance(2.0, 3) == 4 * 6
    assert halo.fdog_iterative(3.0, 1.0, 3, 1.0) == 3 * (3 + halo.fdog(3.0, 1.0))
    assert halo.soft_edges(7.0) == 11 + (9 + 1) + (11 + 1)
    assert halo.fdog(3.0, 1.0, 7.0) == 9 + 1 + halo.soft_edges(7.0)
    assert halo.fdog_iterative(3.0, 1.0, 3, 1.0, 7.0) == 2 * (3 + halo.fdog(3.0, 1.0)) + halo.fdog(3.0, 1.0, 7.0)
    assert halo.fdog_iterative(3.0, 20.0, 3, 1.0, 7.0) == halo.fdog_iterative(3.0, 20.0, 3, 1.0)  # which read farther
    thin = 2 * (4 + 1) + 2 * (2 + 1) + halo.flow_blur(8.0)
    assert halo.fdog(3.0, 1.0, thin_lines=4.0) == halo.fdog(3.0, 1.0) + thin
    assert halo.fdog(3.0, 1.0, 7.0, 2, thin_lines=8.0) == 2 * (5 + 1 + 3 + 1 + thin + 3)
    assert halo.bilateral_oriented(2.0, 0.5, 5, "line") == halo.fbl(2.0, 0.5, 5)
    assert halo.bilateral_oriented(2.0, 0.5, 5, "arc") > halo.fbl(2.0, 0.5, 5)
