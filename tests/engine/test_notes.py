"""Notes are told once, and at the end for all frames that share them."""

import pytest

from flowabs_nodes.engine.notes import NoteBook, frame_range
from flowabs_nodes.engine.report import Note
from flowabs_nodes.io.sequences import parse_frames

SPACE = Note("linear", "plate")


def told(book, frame, *notes):
    return [str(note) for note in book.new(notes, frame)]


def test_a_note_is_told_of_the_first_frame_only():
    book = NoteBook()
    assert told(book, 1, SPACE, Note("reference 1", "flow")) == ["plate: linear", "flow: reference 1"]
    assert told(book, 2, SPACE, Note("reference 2", "flow")) == ["flow: reference 2"]
    assert told(book, 4, Note("linear", "other")) == ["other: linear"]
    assert [(str(note), frames) for note, frames in book.shared()] == [("plate: linear", (1, 2))]


def test_a_word_makes_notes_one_though_their_texts_differ():
    book = NoteBook()
    assert told(book, 1, Note("thin: 0.5", "lines", once="thin")) == ["lines: thin: 0.5"]
    assert told(book, 2, Note("thin: 0.4", "lines", once="thin")) == []
    assert [(str(note), frames) for note, frames in book.shared()] == [("lines: thin: 0.5", (1, 2))]


def test_a_note_that_knows_its_frame_is_about_that():
    book = NoteBook()
    for rendered in (5, 6):
        told(book, rendered, Note("linear", "plate", frame=5), Note("linear", "plate", frame=6))
    assert [frames for _, frames in book.shared()] == [(5, 6)]


def test_details_are_told_but_not_shared():
    book = NoteBook()
    for frame in (1, 2):
        told(book, frame, Note("there already", detail=True))
    assert not list(book.shared())


@pytest.mark.parametrize(
    ("frames", "text"),
    [([7], "7"), ([1, 2, 3], "1-3"), ([12, 9, 11, 10, 5], "5,9-12"), ([1, 3, 5, 7, 20], "1-7x2,20"), ([-2, -1], None)],
)
def test_frames_as_a_range(frames, text):
    assert text in (frame_range(frames), None)
    assert parse_frames(frame_range(frames)) == tuple(sorted(frames))
