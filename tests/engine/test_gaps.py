"""Holes of a sequence are named where every frame on disk is rendered."""

import pytest

from flowabs_nodes.engine.gaps import holes
from tests.engine.sequences import plates, run


@pytest.mark.parametrize(
    ("numbers", "text"),
    [
        ((), None),
        ((5,), None),
        ((1, 2, 3), None),
        ((-2, -1, 0), None),
        ((1001, 1003, 1005, 1007), None),
        ((1, 3), "frame 2 is not on disk"),
        ((1, 2, 5), "frames 3-4 are not on disk"),
        ((1, 2, 3, 4, 8, 9, 10, 11, 13), "frames 5-7, 12 are not on disk"),
        ((1, 3, 5, 9), "frames 2, 4, 6-8 are not on disk"),
        ((1, 10**17), f"frames 2-{10**17 - 1} are not on disk"),
    ],
)
def test_holes(numbers, text):
    said = [str(note) for note in holes(numbers)]
    assert said == (
        [] if text is None else [f"{text} and not made; --frames {numbers[0]}-{numbers[-1]} asks for every frame"]
    )


def test_of_many_holes_the_first_are_named():
    text = str(holes([0, *range(1, 60, 2), 60])[0])
    assert text.startswith("frames 2, 4, 6, 8, 10, 12, 14, 16, ... are not on disk")


def notes(shot, out, **options):
    events = []
    run(shot, out / "out.####.exr", on_event=events.append, **options)
    return [each for each in events if each["event"] == "note" and "on disk" in each["text"]]


def test_a_run_says_what_is_not_there_unless_it_is_told_what_to_make(tmp_path):
    shot = plates(tmp_path / "in", 1, 2, 5)
    (said,) = notes(shot, tmp_path)
    assert (said["level"], said["frame"]) == ("warning", None)
    assert "frames 3-4" in said["text"]
    assert not notes(shot, tmp_path, frames="1-2")
    assert not notes(plates(tmp_path / "whole", 1, 2, 3), tmp_path / "whole")
