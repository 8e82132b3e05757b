import pytest

from flowabs_nodes.filters.flow.etf_update import fixed_point


@pytest.mark.parametrize("pixels", [1, 9, 69, 127, 128, 441, 10_000, 4_000_000])
def test_no_sum_over_a_footprint_leaves_int32(pixels):
    fixed = fixed_point(pixels)
    assert pixels * int(fixed.one) < 2**31
    if fixed.trace_bit > 0:
        assert pixels * int(fixed.one_below) < 2**fixed.trace_bit
        assert pixels * (2**fixed.trace_bit + int(fixed.one_below)) < 2**31


def test_small_footprints_keep_both_traces_in_one_term_finely_enough():
    assert fixed_point(69).trace_bit > 0  # radius 5, the default
    assert fixed_point(69).one_below >= 2**15
    assert fixed_point(10_000).trace_bit == 0
    assert fixed_point(1).one == 2**20
