import numpy as np
import pytest

from flowabs_nodes.filters.flow.footprint_sums import (
    PLANES,
    ROWS,
    Columns,
    Footprints,
    RunningSums,
    SourceRows,
    footprint_passes,
    sum_over_footprints,
)
from flowabs_nodes.filters.flow.line_buffers import halos_of, plan_of

HUGE = 1000  # a picture that no footprint here is too large for
RADII = [0.5, 1.0, 1.5, 2.0, 2.5, 5.0, 5.1, np.sqrt(2), np.sqrt(5), np.sqrt(50), 9.5]


def pixels_of(passes, p, size):
    """The pixels (dx, dy) of one footprint, each as often as its groups name it."""
    found = []
    for m, top, bottom in passes.groups[passes.first[p, size] : passes.first[p, size + 1]]:
        for dy in range(top, bottom + 1):
            found += [(dx, sign * dy) for sign in ((1,) if dy == 0 else (1, -1)) for dx in range(-m, m + 1)]
    return sorted(found)


def disc(radius):
    """Eq. 2, pixel by pixel."""
    around = range(-int(radius) - 2, int(radius) + 3)
    return sorted((dx, dy) for dx in around for dy in around if dx * dx + dy * dy < radius * radius)


@pytest.mark.parametrize("radius", RADII)
def test_the_full_footprint_is_the_open_disc_of_eq_2(radius):
    passes = footprint_passes("full", [radius], HUGE, HUGE)
    assert pixels_of(passes, 0, 0) == disc(radius)
    assert passes.pixels == len(disc(radius))
    np.testing.assert_array_equal(passes.reach, [[max(disc(radius))[0]] * 2])


@pytest.mark.parametrize(("radius", "pixels"), [(1.0, 1), (1.5, 9), (2.0, 9), (2.5, 21), (5.0, 69)])
def test_known_numbers_of_pixels(radius, pixels):
    assert footprint_passes("full", [radius], HUGE, HUGE).pixels == pixels


@pytest.mark.parametrize(("radius", "reach"), [(1.0, 0), (1.5, 1), (2.0, 1), (5.0, 4), (5.1, 5)])
def test_separable_is_a_row_and_then_a_column(radius, reach):
    passes = footprint_passes("separable", [radius], HUGE, HUGE)
    np.testing.assert_array_equal(passes.reach, [[reach, 0], [0, reach]])
    assert pixels_of(passes, 0, 0) == [(d, 0) for d in range(-reach, reach + 1)]
    assert pixels_of(passes, 1, 0) == [(0, d) for d in range(-reach, reach + 1)]
    assert passes.pixels == 2 * reach + 1


@pytest.mark.parametrize("kernel", ["full", "separable"])
@pytest.mark.parametrize("radius", [7.0, 1e30])
def test_no_footprint_reaches_further_than_the_picture(kernel, radius):
    passes = footprint_passes(kernel, [radius], 3, 5)
    assert passes.reach.max(axis=0).tolist() == [4, 2]


def test_each_size_has_its_own_groups():
    passes = footprint_passes("full", [5.0, 2.5], HUGE, HUGE)
    assert pixels_of(passes, 0, 0) == disc(5.0)
    assert pixels_of(passes, 0, 1) == disc(2.5)
    np.testing.assert_array_equal(passes.reach, [[4, 4]])


def direct_sums(terms, footprint):
    """The sum at every pixel, zeros beyond the picture."""
    far = 1 + np.abs(footprint).max()
    padded = np.pad(terms, far)
    height, width = terms.shape
    return sum(padded[far + dy : far + dy + height, far + dx : far + dx + width] for dx, dy in footprint)


@pytest.mark.parametrize("kernel", ["full", "separable"])
def test_sums_are_those_of_each_pixel_of_the_footprint(kernel):
    height, width, planes = 22, 48, 3
    passes = footprint_passes(kernel, [5.0, 3.2], height, width)
    pictures = np.random.default_rng(4).integers(-(2**30), 2**30, (planes, height, width)).astype(np.int32)
    layout, edges = plan_of(passes, np.array([[0, width, 0, height]]), halos_of(passes, 1))[2:]
    for p, (_, reach) in enumerate(passes.reach):
        # Every row from far above the picture to far below, so that no row has to be used again.
        above = int(reach) + 1 + ROWS
        terms = np.zeros((above + height + above + ROWS, PLANES, layout.columns), np.int32)
        terms[above : above + height, :planes, layout.margin : layout.margin + width] = pictures.transpose(1, 0, 2)
        carried = np.zeros(PLANES * layout.groups * ROWS * layout.running_columns, np.int32)
        running = RunningSums(carried, 0, layout.groups, layout.running_columns, layout.running_margin)
        sums = np.empty((2, PLANES, ROWS, layout.columns), np.int32)
        found = np.zeros((2, planes, height, width), np.int32)
        for y in range(-int(reach) // ROWS * ROWS, height, ROWS):
            rows = (above + y + np.arange(-int(reach) - 1, int(reach) + ROWS)) * PLANES * layout.columns
            sum_over_footprints(
                SourceRows(terms.reshape(-1), rows, int(reach) + 1),
                Footprints(passes.groups, passes.first[p], edges),
                running,
                Columns(layout.margin, layout.margin, layout.margin + width),
                planes,
                sums.reshape(-1),
                layout.columns,
            )
            there = slice(max(y, 0), min(y + ROWS, height))
            found[:, :, there] = sums[
                :, :planes, there.start - y : there.stop - y, layout.margin : layout.margin + width
            ]
        for size in range(2):
            for plane in range(planes):
                expected = direct_sums(pictures[plane].astype(np.int64), pixels_of(passes, p, size))
                np.testing.assert_array_equal(found[size, plane], expected.astype(np.int32))  # modulo 2^32
