import numpy as np
from numba import njit

from flowabs_nodes.simd.border import repeat_left, repeat_right


@njit
def _repeat(row, begin, end, margin, channels):
    repeat_left(row, begin, margin, channels)
    repeat_right(row, end, margin, channels)


def test_the_first_and_the_last_pixel_are_repeated():
    row = np.float32([0, 0, 0, 5, 6, 7, 0, 0, 0])
    _repeat(row, 3, 6, 2, 1)
    assert row.tolist() == [0, 5, 5, 5, 6, 7, 7, 7, 0]


def test_pixels_of_two_channels_are_repeated_whole():
    row = np.float32([0, 0, 0, 0, 1, 2, 3, 4, 0, 0, 0, 0])
    _repeat(row, 4, 8, 2, 2)
    assert row.reshape(-1, 2).tolist() == [[1, 2], [1, 2], [1, 2], [3, 4], [3, 4], [3, 4]]


def test_a_row_of_one_pixel_is_that_pixel_everywhere():
    row = np.float32([0, 0, 9, 0, 0])
    _repeat(row, 2, 3, 2, 1)
    assert row.tolist() == [9] * 5
