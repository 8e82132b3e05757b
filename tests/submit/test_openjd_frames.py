import random

import pytest

from flowabs_nodes.io.sequences import parse_frames
from flowabs_nodes.submit.openjd_frames import from_openjd, to_openjd


@pytest.mark.parametrize(
    ("openjd", "ours"),
    [("1001-1100:2", "1001-1100x2"), ("7", "7"), ("-5--1:2, 9", "-5--1x2,9"), ("1-4,8-10", "1-4,8-10")],
)
def test_a_chunk_reaches_us_in_our_form(openjd, ours):
    assert from_openjd(openjd) == ours
    parse_frames(ours)


@pytest.mark.parametrize("wrong", ["", "1-10x2", "1:2", "a", "1,,2"])
def test_what_is_no_range_of_openjd(wrong):
    with pytest.raises(ValueError, match="is not a range of Open Job Description"):
        from_openjd(wrong)


@pytest.mark.parametrize(
    ("ours", "openjd"),
    [("1001-1100x2", "1001-1099:2"), ("1-3,7", "1-3,7"), ("10-1", "1-10"), ("1,5,6,7", "1,5-7"), ("-4-4x4", "-4-4:4")],
)
def test_ranges_are_written_with_a_colon(ours, openjd):
    assert to_openjd(parse_frames(ours)) == openjd


def test_there_and_back_are_the_same_frames():
    numbers = random.Random(12)
    for _ in range(200):
        frames = {numbers.randint(-30, 30) for _ in range(numbers.randint(1, 40))}
        assert parse_frames(from_openjd(to_openjd(frames))) == tuple(sorted(frames))
