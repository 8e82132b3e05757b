import numpy as np
import pytest

from flowabs_nodes.filters.flow.gaussian_pyramid import MARGIN, first_level, sum_over_scales
from tests.naive.fill import smoothing


@pytest.mark.parametrize("level", [1, 2, 3, 4, 5])
def test_each_level_is_a_gaussian_that_does_not_know_the_grid(level):
    size = 64 * 2**level
    middle = slice(24 * 2**level, 40 * 2**level)
    offsets = np.arange(size)
    rows = smoothing(size, level)[middle]
    kernels = np.array([np.roll(row, size // 2 - 24 * 2**level - i) for i, row in enumerate(rows)])
    np.testing.assert_allclose(kernels.sum(axis=1), 1, atol=1e-9)
    limit = 5e-4 if level == 1 else 2e-4
    assert np.abs(kernels - kernels.mean(axis=0)).max() < limit * kernels.max()
    sigma = np.sqrt(kernels.mean(axis=0) @ (offsets - size // 2) ** 2)
    assert 1.2 < sigma / 2**level < 1.45


@pytest.mark.parametrize(("height", "width"), [(1, 40), (33, 1), (50, 77), (129, 16)])
def test_levels_add_up_with_half_the_weight_each(height, width):
    rng = np.random.default_rng(4)
    level = first_level(2, height, width)
    level[:] = 0
    level[:, MARGIN : MARGIN + height // 2, MARGIN : MARGIN + width // 2] = rng.random((2, height // 2, width // 2))
    far = 128 - MARGIN  # so that the grids of all levels begin in the same place
    before = np.pad(level.astype(np.float64), ((0, 0), (far, 0), (far, 0)))
    sum_over_scales(level, height, width)
    expected = before.copy()
    for k in range(1, 20):
        if 2**k >= max(height, width) / 2:
            break
        along_y, along_x = (smoothing(size, k) for size in before.shape[1:])
        expected += 0.5**k * np.einsum("yj,pji,xi->pyx", along_y, before, along_x, optimize=True)
    columns = MARGIN + width // 2
    np.testing.assert_allclose(level[:, :, :columns], expected[:, far:, far : far + columns], rtol=2e-6, atol=1e-7)
