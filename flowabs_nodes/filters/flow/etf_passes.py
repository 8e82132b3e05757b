"""All iterations of eq. 1 in one go: tiles of the picture, whose passes follow each other down the rows.

A pass works on four rows at once, as far behind the pass before as its footprints reach down: it sums the terms of the
rows around (``footprint_sums.py``), then turns the tangents (``etf_update.py``). Rows go from one pass to the next
through line buffers (``line_buffers.py``); in memory every pixel is read once and written once.
"""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array, Int32
from flowabs_nodes.filters.flow.etf_update import Block, Field, FixedPoint, Step, begin, fixed_point, turn_tangents
from flowabs_nodes.filters.flow.footprint_sums import (
    PLANES,
    ROWS,
    Columns,
    Footprints,
    Passes,
    RunningSums,
    SourceRows,
    sum_over_footprints,
)
from flowabs_nodes.filters.flow.line_buffers import (
    Plan,
    clear,
    clear_terms,
    halos_of,
    new_aligned,
    new_line_buffers,
    plan_of,
    tiles_of,
    whole_vectors_inlined,
)
from flowabs_nodes.simd.bands import over_rows
from flowabs_nodes.simd.jit import inlined, kernel
from flowabs_nodes.simd.lanes import LANES

TILE_COLUMNS = 400  # about: a tile's line buffers stay in the second-level cache
TILE_TO_HALO = 10  # a tile is at least so many times as wide as its halo on one side
HALO = 64  # pixels: more iterations than fit into such a halo are done in several goes


def smooth(
    tangent: Array,
    magnitude: Array,
    reference: float,
    iterations: int,
    passes: Passes,
    choice: Int32 | None = None,
    mask: Array | None = None,
) -> Array:
    """Smooth a field of tangents ``iterations`` times by eq. 1 (section 2.3).

    Parameters
    ----------
    tangent
        (H, W, 2), unit or zero. It may be overwritten.
    magnitude
        |g|, (H, W), in the unit of ``reference``.
    reference
        Gradient of full strength, ĝ = min(|g| / reference, 1); 0 gives ĝ = 0.
    iterations
        At least 1.
    passes
        The footprints of an iteration.
    choice
        (H, W) int32, which size of footprint of ``passes`` each pixel takes; None if there is one size.
    mask
        (H, W), 0 to 1, what the weight of each pixel in the sums is multiplied by; None is 1 everywhere.

    Returns
    -------
    (H, W, 2) float32, unit or zero; a tangent whose sum is zero stays as it was.
    """
    height, width = magnitude.shape
    sizes = passes.first.shape[1] - 1
    if choice is None:
        choice = np.zeros((1, 1), np.int32)
    elif width < LANES:
        choice = np.pad(choice, [(0, 0), (0, LANES - width)])
    if width < LANES:  # beside the picture there are no tangents
        beside = [(0, 0), (0, LANES - width)]
        tangent, magnitude = np.pad(tangent, [*beside, (0, 0)]), np.pad(magnitude, beside)
        mask = None if mask is None else np.pad(mask, beside)
    columns = magnitude.shape[1]
    # Next to no reference gives ĝ = 1 wherever there is a gradient, and none gives ĝ = 0.
    inverse = np.float32(min(1 / reference, float(np.finfo(np.float32).max)) if reference > 0 else 0)
    weights = np.empty(0, np.float32) if mask is None else mask.reshape(-1)
    fixed = fixed_point(passes.pixels, fractions=mask is not None)
    at_once = max(1, int(HALO // max(1, passes.reach.sum(axis=0).max())))
    smoothed = np.empty_like(tangent)
    while iterations > 0:
        now = min(iterations, at_once)
        strength = magnitude.reshape(-1)
        field = Field(tangent.reshape(-1), strength, weights, inverse, choice.reshape(-1), sizes, height, columns)
        halos = halos_of(passes, now)
        tiles = tiles_of(height, columns, max(TILE_COLUMNS, TILE_TO_HALO * int(halos[0, 0])))
        plan = plan_of(passes, tiles, halos)
        over_rows(_smooth, len(tiles), plan, passes, field, fixed, smoothed.reshape(-1), least=1, most=1)
        tangent, smoothed, iterations = smoothed, tangent, iterations - now
    return np.ascontiguousarray(tangent[:, :width])


@kernel
def _smooth(
    first: int, last: int, plan: Plan, passes: Passes, field: Field, fixed: FixedPoint, smoothed: Array
) -> None:
    """Write the smoothed tangents of the tiles ``first`` .. ``last`` - 1 into ``smoothed``, (H, W, 2) flattened."""
    tiles, halos, layout, edges = plan
    kinds, steps, height, width = passes.first.shape[0], halos.shape[0] - 1, field.height, field.width
    buffers = new_line_buffers(layout, kinds, field.sizes, steps)
    terms_of_a_row = PLANES * layout.columns
    running_of_a_pass = PLANES * layout.groups * ROWS * layout.running_columns
    running = new_aligned(steps * running_of_a_pass)
    rows = np.empty(layout.term_rows, np.int64)
    for tile in range(first, last):
        left, right, top, bottom = tiles[tile, 0], tiles[tile, 1], tiles[tile, 2], tiles[tile, 3]
        origin = layout.margin - left
        clear(buffers.terms, 0, buffers.terms.size)
        clear(running, 0, running.size)
        for newest in range(max(top - halos[0, 1], 0), bottom + halos[0, 1], ROWS):
            end = newest + ROWS
            x0, x1 = _columns_of(left, right, halos[0, 0], width)
            begin(Block(newest, newest, min(end, height), x0, x1, origin), field, fixed, buffers.terms, layout)
            clear_terms(buffers.terms, layout, 0, max(newest, height), end)
            y = newest
            for p in range(steps):
                step = Step(p, p % kinds, kinds, steps)
                reach = passes.reach[step.kind, 1]
                y -= reach
                for d in range(2 * reach + 1 + ROWS):
                    rows[d] = (p * layout.term_rows + (y + d - reach - 1) % layout.term_rows) * terms_of_a_row
                before, _ = _columns_of(left, right, halos[p, 0], width)
                x0, x1 = _columns_of(left, right, halos[p + 1, 0], width)
                sum_over_footprints(
                    SourceRows(buffers.terms, rows, reach + 1),
                    Footprints(passes.groups, passes.first[step.kind], edges),
                    RunningSums(
                        running, p * running_of_a_pass, layout.groups, layout.running_columns, layout.running_margin
                    ),
                    Columns(origin + before, origin + x0, origin + x0 + whole_vectors_inlined(x1 - x0)),
                    4 if p >= kinds else 5 if fixed.trace_bit > 0 else PLANES,
                    buffers.sums,
                    layout.columns,
                )
                first_row, last_row = max(top - halos[p + 1, 1], 0), min(bottom + halos[p + 1, 1], height)
                ready = Block(y, max(y, first_row), min(y + ROWS, last_row), x0, x1, origin)
                turn_tangents(step, ready, field, fixed, buffers, layout, smoothed)
                if y + ROWS <= first_row:
                    break  # the next pass has nothing to read yet
                if p + 1 < steps:
                    clear_terms(buffers.terms, layout, p + 1, max(y, height), y + ROWS)


@inlined
def _columns_of(left: int, right: int, halo: int, width: int) -> tuple[int, int]:
    """Return the first column of a tile with so large a halo, a multiple of sixteen, and the one after the last."""
    return max(left - whole_vectors_inlined(halo), 0), min(right + halo, width)
