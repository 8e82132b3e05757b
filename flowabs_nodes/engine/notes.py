"""Keeps the notes of all frames, so that each is told once, and at the end which frames share it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from flowabs_nodes.engine.report import Note


@dataclass
class _Said:
    """What was said first, and the frames that it is true of."""

    note: Note
    frames: set[int] = field(default_factory=set)


class SharedNote(NamedTuple):
    """A note that several frames share: what was said of the first, and the frames in order."""

    note: Note
    frames: tuple[int, ...]


class NoteBook:
    """Remembers which notes of a run have been told, and of which frames they are true."""

    def __init__(self) -> None:
        self._said: dict[tuple[str, str], _Said] = {}

    def new(self, notes: Iterable[Note], frame: int) -> Iterator[Note]:
        """Yield those notes of a rendered frame that have been told of no frame yet, and remember them all.

        Notes are the same if node and text are, or node and ``once``.
        """
        for note in notes:
            said = self._said.setdefault((note.node, note.once or note.text), _Said(note))
            if not said.frames:
                yield note
            said.frames.add(frame if note.frame is None else note.frame)

    def shared(self) -> Iterator[SharedNote]:
        """Yield the notes that several frames share, in the order in which they were first told."""
        for said in self._said.values():
            if len(said.frames) > 1 and not said.note.detail:
                yield SharedNote(said.note, tuple(sorted(said.frames)))


def frame_range(frames: Iterable[int]) -> str:
    """Return frames as the range that ``--frames`` takes, in order: "1-3,5-9x2,20"."""
    import fileseq  # whoever renders a single picture need not wait for it

    text: str = fileseq.framesToFrameRange(sorted(frames))
    return text
