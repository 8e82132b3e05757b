import numpy as np
import pytest

from flowabs_nodes.engine.frame_numbers import frame_number, frame_numbers
from flowabs_nodes.errors import ArgumentError, CommandError


@pytest.mark.parametrize("one", [7, np.int64(7), np.uint8(7), np.int16(7), np.array(7)])
def test_a_whole_number_of_any_kind_is_a_frame(one):
    assert frame_number(one) == 7
    assert type(frame_number(one)) is int
    assert frame_numbers(one) == (7,)


@pytest.mark.parametrize(
    "frames",
    [np.arange(1, 4), range(1, 4), "1-3", [np.int32(1), 2, np.uint8(3), 1], iter((1, 2, 3)), {1: "", 2: "", 3: ""}],
)
def test_several_frames_each_once(frames):
    found = frame_numbers(frames)
    assert found == (1, 2, 3)
    assert {type(number) for number in found} == {int}


@pytest.mark.parametrize("wrong", [1.5, 1.0, np.float64(2), True, np.bool_(True), "1", None, [1], np.array([1])])
def test_what_is_no_frame(wrong):
    with pytest.raises(ArgumentError, match="expected a whole number, found"):
        frame_number(wrong)


@pytest.mark.parametrize(
    ("wrong", "found"),
    [
        (1.5, "1.5"),
        (np.array([1, 2.5]), "1.0"),
        (True, "True"),
        (np.array([True, False]), "True"),
        ([1, "2"], "'2'"),
        ([1, None], "None"),
        ([], r"\[\]"),
        (np.arange(0), r"array\(\[\]"),
        (np.ones((2, 2), int), r"array\(\[\["),
        (b"12", "b'12'"),
    ],
)
def test_what_are_no_frames(wrong, found):
    with pytest.raises(CommandError, match=f"whole numbers, found .*{found}"):
        frame_numbers(wrong)
