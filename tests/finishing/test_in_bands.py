"""Anybody's operations run in the pass that decodes, among ours and in order, whatever the bands are."""

from __future__ import annotations

import sys
import threading

import numpy as np
import pytest

from flowabs_nodes import color, filters
from flowabs_nodes.array_types import Array
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.errors import ArgumentError, FlowabsError, InternalError
from flowabs_nodes.finishing.finish import finish, finish_pixels
from flowabs_nodes.finishing.fused import quantized
from flowabs_nodes.finishing.operations import Ink, OnRows, Operation, Quantize, RowsFunction
from flowabs_nodes.simd.bands import limited

REC709 = color.space("lin_rec709")
SHAPE = (67, 37)
RANDOM = np.random.default_rng(11)
RGB = RANDOM.uniform(0, 1.5, (*SHAPE, 3)).astype(np.float32)
ALPHA = np.clip(RANDOM.uniform(-0.3, 1.3, (*SHAPE, 1)), 0, 1).astype(np.float32)
UNDER = np.concatenate([RGB * ALPHA, ALPHA], 2)
QUANTIZE, INK = Quantize(4, 0.3), Ink(RANDOM.random(SHAPE, np.float32), (0.1, 0.2, 0.3), 0.7)
BY_GRADIENT = Quantize(4, 0.3, 0.2, 1.1, 0.9, 4.0, 6 * RANDOM.random(SHAPE, np.float32))


def ramp(rows: Array, first_row: int) -> None:
    """Darken each row by its number, in place."""
    rows[..., :3] /= np.float32(1) + np.arange(first_row, first_row + len(rows), dtype=np.float32)[:, None, None]


def swapped(rows: Array, first_row: int) -> Array:
    """Swap red and blue, in other rows."""
    return rows[..., [2, 1, 0, 3][: rows.shape[2]]]


def one_after_the_other(pixels: Array, operations: tuple[Operation, ...]) -> Array:
    """Do the operations on a whole picture, each on its own."""
    for operation in operations:
        if isinstance(operation, Quantize):
            pixels = quantized(pixels, operation, REC709)
        elif isinstance(operation, Ink):
            alpha = pixels[..., 3] if pixels.shape[2] == 4 else None
            rgb = filters.composite(pixels[..., :3], operation.lines, operation.color, operation.opacity, alpha)
            pixels = np.concatenate([rgb, pixels[..., 3:]], 2)
        else:
            rows = pixels.copy()
            result = operation.function(rows, 0)
            pixels = np.ascontiguousarray(rows if result is None else result)
    return pixels


@pytest.mark.parametrize("under", [None, UNDER], ids=["opaque", "alpha"])
@pytest.mark.parametrize("space", color.SPACES)
@pytest.mark.parametrize(
    "operations",
    [
        (OnRows(ramp),),
        (OnRows(swapped), OnRows(ramp)),
        (OnRows(ramp), QUANTIZE, INK),
        (INK, QUANTIZE),
        (OnRows(swapped), BY_GRADIENT, INK),
        (OnRows(ramp), BY_GRADIENT),
        (INK, OnRows(swapped), INK),
    ],
)
def test_equals_the_steps_one_after_the_other(
    operations: tuple[Operation, ...], space: str, under: Array | None
) -> None:
    codes = Codes(color.encode(RGB, space), space, under)
    head = operations[:1] if operations[0] is INK else ()
    first = finish(codes, head, REC709)
    expected = one_after_the_other(first, operations[len(head) :])
    for threads in (1, 2, 5):
        with limited(threads):
            np.testing.assert_array_equal(finish(codes, operations, REC709), expected)


def test_ours_before_a_function_are_done_by_the_kernel() -> None:
    codes = Codes(color.encode(RGB), "lab")
    found = finish(codes, (QUANTIZE, INK, OnRows(swapped)), REC709)
    np.testing.assert_array_equal(found, finish(codes, (QUANTIZE, INK), REC709)[..., ::-1])


def test_threads_share_the_bands() -> None:
    seen, both = [], threading.Barrier(2, timeout=20)

    def watch(rows: Array, first_row: int) -> None:
        if not seen:
            both.wait()  # two bands at once
        seen.append((first_row, len(rows)))

    with limited(2):
        finish_pixels(RGB, OnRows(watch), REC709)
    assert sum(count for _, count in seen) == SHAPE[0]
    assert [first for first, _ in sorted(seen)] == list(np.cumsum([0] + [count for _, count in sorted(seen)])[:-1])


def test_pixels_are_copied_for_the_function() -> None:
    before = RGB.copy()
    np.testing.assert_array_equal(finish_pixels(RGB, OnRows(swapped), REC709), RGB[..., ::-1])
    finish_pixels(RGB, OnRows(ramp), REC709)
    np.testing.assert_array_equal(RGB, before)


@pytest.mark.parametrize(
    ("function", "words"),
    [
        (lambda rows, first_row: rows[:, :1], r"must return float32 rows .*, or None, it returned float32"),
        (lambda rows, first_row: 7, "it returned int"),
        (lambda rows, first_row: rows.astype(complex), "it returned complex128"),
        (lambda rows, first_row: rows * np.float32(2), "must leave alpha as it is"),
        (lambda rows, first_row: 1 / 0, "ZeroDivisionError: division by zero"),
        (lambda rows, first_row: sys.exit(3), "tried to end the whole process .SystemExit: 3"),
    ],
)
def test_a_bad_function_is_its_node_s_fault(function: RowsFunction, words: str) -> None:
    codes = Codes(color.encode(RGB), "lab", UNDER)
    with pytest.raises(InternalError, match=words) as failure:
        finish(codes, (QUANTIZE, OnRows(function, "tint")), REC709)
    assert failure.value.node == "tint"


def test_its_own_errors_stay_and_get_the_node() -> None:
    def refuse(rows: Array, first_row: int) -> None:
        raise FlowabsError("too odd", code="odd")

    with pytest.raises(FlowabsError, match="node tint: too odd") as failure:
        finish_pixels(RGB, OnRows(refuse, "tint"), REC709)
    assert failure.value.code == "odd"


def test_numbers_of_float64_become_float32() -> None:
    found = finish_pixels(RGB, OnRows(lambda rows, first_row: rows.astype(np.float64) * 2), REC709)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, RGB * np.float32(2))


def test_code_values_that_are_not_finite_are_counted_once() -> None:
    values = color.encode(RGB)
    values[[0, -1], 0] = np.nan
    with pytest.raises(ArgumentError, match="codes: expected finite pixels, found 6"):
        finish(Codes(values, "lab"), (OnRows(ramp),), REC709)
