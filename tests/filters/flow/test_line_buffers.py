import numpy as np
import pytest

from flowabs_nodes.filters.flow import line_buffers
from flowabs_nodes.filters.flow.footprint_sums import PLANES, ROWS, footprint_passes
from flowabs_nodes.simd.bands import limited


@pytest.mark.parametrize("threads", [1, 2, 5, 15, 16])
@pytest.mark.parametrize(("height", "width"), [(1, 16), (300, 31), (40, 2020), (2, 2049), (1080, 1920)])
def test_tiles_are_the_picture_once_and_wide_enough(threads, height, width):
    with limited(threads):
        tiles = line_buffers.tiles_of(height, width, 400)
    covered = np.zeros((height, width), int)
    for left, right, top, bottom in tiles:
        assert left % 16 == 0
        assert right - left >= 16
        covered[top:bottom, left:right] += 1
    np.testing.assert_array_equal(covered, 1)


def test_a_halo_is_what_all_later_passes_reach():
    full = footprint_passes("full", [5.0], 1000, 1000)
    np.testing.assert_array_equal(line_buffers.halos_of(full, 3), [[12, 12], [8, 8], [4, 4], [0, 0]])
    separable = footprint_passes("separable", [3.0], 1000, 1000)
    np.testing.assert_array_equal(line_buffers.halos_of(separable, 2), [[4, 4], [2, 4], [2, 2], [0, 2], [0, 0]])


@pytest.mark.parametrize("kernel", ["full", "separable"])
@pytest.mark.parametrize("radius", [1.5, 5.0, 20.0])
def test_a_plan_has_room_for_every_tile_and_its_halo(kernel, radius):
    passes = footprint_passes(kernel, [radius, 2.0], 300, 700)
    tiles, halos = line_buffers.tiles_of(300, 700, 200), line_buffers.halos_of(passes, 2)
    layout, edges = line_buffers.plan_of(passes, tiles, halos)[2:]
    assert layout.columns % 16 == 0
    assert layout.margin >= halos[0, 0]
    assert layout.columns - layout.margin >= (tiles[:, 1] - tiles[:, 0]).max() + halos[0, 0]
    assert layout.term_rows >= 2 * passes.reach[:, 1].max() + 1 + ROWS
    assert layout.tangent_rows >= halos[0, 1] + ROWS
    # What enters at x + m and leaves at x - m - 1 lies within a group's row of running sums, x from -reach on.
    np.testing.assert_array_equal(edges[:, 0] - edges[:, 1], 2 * passes.groups[:, 0] + 1)
    column = edges % (ROWS * layout.running_columns)
    assert column.min() >= passes.reach[:, 0].max()
    assert column.max() + layout.columns - layout.margin <= layout.running_columns


def test_rows_of_a_buffer_are_used_again_after_as_many_rows():
    layout = line_buffers.Layout(64, 16, 5, 7, 1, 96, 32)
    for at, rows, size in [
        (line_buffers.terms_at.py_func, 5, PLANES * 64),
        (line_buffers.tangents_at.py_func, 7, 2 * 64),
        (line_buffers.trace_at.py_func, 7, 64),
    ]:
        begins = [at(layout, p, y) for p in range(3) for y in range(rows)]
        assert sorted(begins) == list(range(0, 3 * rows * size, size))
        assert at(layout, 1, rows + 2) == at(layout, 1, 2)
        assert at(layout, 1, -1) == at(layout, 1, rows - 1)


@pytest.mark.parametrize("size", [16, 17, 1000])
def test_memory_begins_with_a_cache_line(size):
    memory = line_buffers.new_aligned(size)
    assert memory.dtype == np.int32
    assert memory.size == size
    assert memory.ctypes.data % 64 == 0


def test_what_is_cleared_is_zero_and_nothing_else():
    numbers = np.ones(80, np.int32)
    line_buffers.clear(numbers, 16, 48)
    assert not numbers[16:48].any()
    assert numbers[:16].all()
    assert numbers[48:].all()


@pytest.mark.parametrize(("columns", "whole"), [(0, 0), (1, 16), (16, 16), (17, 32)])
def test_whole_vectors(columns, whole):
    assert line_buffers.whole_vectors(columns) == whole
