"""The mask of ``etf``: how much each pixel counts."""

import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import etf, measure_reference
from flowabs_nodes.filters.flow.adaptive import kernel_choice
from tests.filters.pictures import noise, photo
from tests.naive import etf as naive

GREY = photo().mean(-1)


def soft(height, width):
    """A mask with a ramp at its edge, 0 on one side and 1 on the other."""
    y, x = np.mgrid[:height, :width]
    return np.clip((np.hypot(x - width / 2, y - height / 2) - height / 5) / 6, 0, 1).astype(np.float32)


@pytest.mark.parametrize(
    "code", [GREY, photo(), noise(140, 41), noise(40, 9)], ids=["photo", "colour", "noise", "thin"]
)
@pytest.mark.parametrize(
    ("radius", "kernel", "fill"),
    [(5.0, "full", None), (7.5, "full", 2.0), (20.0, "full", 0.0), (5.0, "separable", 0.0)],
)
def test_equals_the_equations_in_float64(code, radius, kernel, fill):
    mask = soft(*code.shape[:2])
    flow = etf(code, radius, 3, kernel, fill=fill, mask=mask)
    error = naive.degrees_between(flow, naive.etf(code, radius, 3, kernel, fill=fill, mask=mask))
    assert flow.dtype == np.float32
    assert np.median(error) < 2e-4
    assert np.quantile(error, 0.999) < 0.05


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"radius": 30.0},
        {"fill": 4.0},
        {"fill": None},
        {"gradient_reference": "p99"},
        {"radius": 9, "adaptive": True},
    ],
)
def test_a_mask_of_ones_changes_nothing_but_rounding(options):
    ones = np.ones(GREY.shape, np.float32)
    assert naive.degrees_between(etf(GREY, mask=ones, **options), etf(GREY, **options)).max() < 0.01


@pytest.mark.parametrize("fill", [None, 0.0, 4.0])
@pytest.mark.parametrize("adaptive", [False, True])
def test_what_is_masked_out_does_not_matter_for_the_rest(fill, adaptive):
    mask = (np.mgrid[:64, :80][1] >= 40).astype(np.float32)
    code, other = (np.where(np.arange(80) < 38, noise(64, 80, seed), noise(64, 80, 3)) for seed in (4, 5))
    options = {"radius": 9.0, "fill": fill, "adaptive": adaptive, "gradient_reference": "p99"}
    one, two = (etf(each, mask=mask, **options) for each in (code, other))
    if adaptive:  # what decides about the kernel is blurred across the edge, but masked first
        np.testing.assert_array_equal(*(kernel_choice(each, 9.0, mask) for each in (code, other)))
    np.testing.assert_array_equal(one, two)  # and where the mask is 0 the flow comes from the rest too
    assert (etf(code, **options)[:, 42:46] != etf(other, **options)[:, 42:46]).any()


def test_a_hole_is_filled_from_around_it():
    y, x = np.mgrid[:80, :80]
    code = 3.0 * y + np.where(np.hypot(x - 40, y - 40) < 12, noise(80, 80), 0)
    mask = (np.hypot(x - 40, y - 40) > 15).astype(np.float32)
    assert naive.degrees_between(etf(code), [1, 0]).max() > 30
    assert naive.degrees_between(etf(code, mask=mask), [1, 0]).max() < 0.01


def test_what_counts_next_to_nothing_turns_next_to_nothing():
    mask = soft(*GREY.shape)
    faint, none = (etf(GREY, mask=np.maximum(mask, low)) for low in (1e-4, 0))
    assert naive.degrees_between(faint, none)[mask > 0.1].max() < 0.5


def test_the_reference_is_that_of_what_counts():
    code, mask = GREY.copy(), np.ones(GREY.shape)
    code[:10, :10] += noise(10, 10) * 100
    mask[:12, :12] = 0
    for reference in ("max", "p99"):
        assert measure_reference(code, reference, mask=mask) < measure_reference(code, reference)
        np.testing.assert_array_equal(
            etf(code, gradient_reference=reference, mask=mask),
            etf(code, gradient_reference=measure_reference(code, reference, mask=mask), mask=mask),
        )
        assert measure_reference(code, reference, mask=0 * mask) == 0


def test_where_nothing_counts_the_flow_is_that_of_a_flat_picture():
    np.testing.assert_array_equal(etf(GREY, mask=0 * GREY), np.broadcast_to([1, 0], (*GREY.shape, 2)))
    assert not etf(GREY, fill=None, mask=0 * GREY).any()


@pytest.mark.parametrize("options", [{}, {"kernel": "separable"}, {"fill": 3.0, "pre_blur": 1.0}])
def test_every_number_of_threads_gives_the_same_bits(each_thread_count, options):
    code, mask = noise(150, 50), soft(150, 50)
    one, *others = each_thread_count(lambda: etf(code, 6.0, mask=mask, **options))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "mask", [np.ones((4, 5)), np.full((4, 4), 1.5), np.full((4, 4), -0.1), np.full((4, 4), np.nan), np.ones((4, 4, 1))]
)
def test_errors_name_the_mask(mask):
    for call in (etf, lambda code, mask: measure_reference(code, "max", mask=mask)):
        with pytest.raises(ArgumentError, match="mask") as error:
            call(np.zeros((4, 4)), mask=mask)
        assert error.value.parameter == "mask"
