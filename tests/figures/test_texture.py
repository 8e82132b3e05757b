"""Fig. 10: a texture smaller than the kernel, and the adaptive kernel that draws it all the same."""

import numpy as np
import pytest

from flowabs_nodes.filters import etf, fdog, fdog_iterative, threshold
from tests.figures.graphs import code, run
from tools.gallery import drawings
from tools.gallery.measures import cells_kept, ink_components

TEXTURE = drawings.small_texture()


def test_a_small_kernel_draws_the_net_a_large_one_does_not_an_adaptive_one_does():
    drawn = run("fig10", TEXTURE, "mu_3", "mu_5", "adaptive")
    assert cells_kept(drawn["mu_3"], TEXTURE) > 0.98
    assert cells_kept(drawn["mu_5"], TEXTURE) < 0.75
    assert cells_kept(drawn["adaptive"], TEXTURE) > 0.98


@pytest.mark.parametrize("period", [7.0, 10.0])
def test_it_does_so_for_finer_and_coarser_nets_and_larger_kernels(period):
    net = drawings.small_texture(period)
    for radius in (5, 7, 10):
        kept = [
            cells_kept(threshold(fdog(net, etf(net, radius, adaptive=adaptive))), net) for adaptive in (False, True)
        ]
        assert kept[1] > 0.965
        assert kept[1] > kept[0] - 0.01


@pytest.mark.parametrize("name", ["chelsea.png", "coffee.exr"])
def test_photographs_come_to_no_harm(name):
    picture = code(name)
    drawn = []
    for adaptive in (False, True):
        flow = etf(picture, pre_blur=1, gradient_reference=16, fill=2, adaptive=adaptive)
        drawn.append(fdog_iterative(picture, flow, rho=1, contrast=1.5, iterations=2)[0])
    plain, adapted = (ink_components(lines) for lines in drawn)
    assert adapted.pieces < 1.05 * plain.pieces
    assert adapted.mean_size > 0.95 * plain.mean_size
    assert ((drawn[0] < 0.5) != (drawn[1] < 0.5)).sum() < 0.05 * (drawn[0] < 0.5).sum()


def test_cells_kept():
    net = np.where(TEXTURE < 128, 0.0, 1.0)
    assert cells_kept(net, TEXTURE) > 0.98
    assert cells_kept(np.ones_like(net), TEXTURE) == 0
    assert cells_kept(np.zeros_like(net), TEXTURE) == 0
