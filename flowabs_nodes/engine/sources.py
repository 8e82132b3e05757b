"""Finds the file that each read node takes on a frame, by the policy for missing frames where it is not there."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.notes import frame_range
from flowabs_nodes.engine.plan import Step, Unit, file_role
from flowabs_nodes.engine.report import Note
from flowabs_nodes.errors import CommandError, ReadError, likely
from flowabs_nodes.io.hashing import content_hash
from flowabs_nodes.io.image_file import check_picture
from flowabs_nodes.io.sequences import Sequence, Source
from flowabs_nodes.io.settings import checked

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.graph.model import Graph

#: So many names of a folder are looked at for the one that was meant.
_MOST_NAMES = 2000


class Sources:
    """Finds the sources of units that read, each once; ``options.missing`` goes before the node's own policy.

    ``params`` are the units' parameters. With ``open_files`` False no file is looked into: it is known by its name.
    """

    def __init__(
        self, graph: Graph, params: Mapping[Unit, Mapping[str, Any]], options: RunOptions, *, open_files: bool = True
    ) -> None:
        self._open_files = open_files
        self._graph = graph
        self._params = params
        self._options = options
        self._found: dict[Unit, Source] = {}
        self._sequences: dict[str, Sequence] = {}  # by pattern
        self._on_disk: dict[str, tuple[int, ...]] = {}
        self._hints: dict[str, str] = {}  # what is there where files are missing, by node

    def of(self, unit: Unit) -> Source:
        """Return the source of a unit that reads.

        Raises
        ------
        CommandError
            file-not-set, or outside-root.
        ReadError
            missing-file, with node and frame, where the policy does not help; what :func:`check_picture` raises.
        """
        if unit not in self._found:
            with error_boundary(unit.node, unit.frame):
                policy = self._options.missing or self._params[unit].get("missing", "error")
                try:
                    source = self._sequence(unit).resolve(unit.frame, policy)
                except ReadError as error:
                    error.hint = error.hint or self._what_is_there(unit)
                    raise
                if source.path is not None:
                    checked(source.path, self._options.settings)
                    if self._open_files and reads_pictures(self._graph, unit.node):
                        check_picture(source.path, self._options.settings)
                self._found[unit] = source
        return self._found[unit]

    def of_steps(self, steps: Iterable[Step]) -> dict[Unit, Source]:
        """Return the source of every step that reads; errors are as in :meth:`of`."""
        return {step.unit: self.of(step.unit) for step in steps if file_role(self._graph, step.unit.node) == "input"}

    def notes(self, sources: Mapping[Unit, Source]) -> tuple[Note, ...]:
        """Return what each unit reads: a note where that stands in for a missing file, else a detail."""
        said = []
        for unit, source in sources.items():
            text = f"reads {source.path}"
            if stands_in := source.black or source.path not in self._sequence(unit).paths(unit.frame):
                what = f"black, of the size of {source.path}," if source.black else source.path
                text = f"its file is missing: {what} is read in its place"
            said.append(Note(text, unit.node, frame=unit.frame, detail=not stands_in))
        return tuple(said)

    def frames_on_disk(self, unit: Unit) -> tuple[int, ...]:
        """Return the frames that are on disk of the sequence that a unit reads, in order; none of a single picture.

        Raises
        ------
        CommandError
            file-not-set.
        ReadError
            The folder cannot be listed.
        """
        if unit.node not in self._on_disk:
            with error_boundary(unit.node, unit.frame):
                sequence = self._sequence(unit)
                self._on_disk[unit.node] = sequence.frames_on_disk() if sequence.has_token else ()
        return self._on_disk[unit.node]

    def _what_is_there(self, unit: Unit) -> str:
        """Return a hint for a file that is missing; it is the same for all frames of a node."""
        if unit.node not in self._hints:
            self._hints[unit.node] = self._look_around(unit)
        return self._hints[unit.node]

    def _look_around(self, unit: Unit) -> str:
        """Return a hint: the frames that are on disk, else the file of the nearest name."""
        if frames := self.frames_on_disk(unit):
            there = f"frames {frame_range(frames)} are there" if len(frames) > 1 else f"frame {frames[0]} is there"
            return f"{there}; --missing says what to read for others"
        sequence = self._sequence(unit)
        folder, name = os.path.split(sequence.path(unit.frame))
        try:
            names = sorted(os.listdir(folder or "."))[:_MOST_NAMES]
        except OSError:
            return ""
        if sequence.has_token:  # of another sequence, whatever its frames are
            return likely(_with_token(name), {_with_token(each) for each in names})
        return likely(name, names)

    def _sequence(self, unit: Unit) -> Sequence:
        """Return the sequence or single picture that a unit reads."""
        pattern = file_of(self._graph, unit.node, self._params[unit])
        if pattern not in self._sequences:
            self._sequences[pattern] = Sequence.to_read(pattern)
        return self._sequences[pattern]


def _with_token(name: str) -> str:
    """Return a file name with # for each digit: "a.####.exr" for a.0001.exr."""
    return re.sub(r"\d", "#", name)


def reads_pictures(graph: Graph, node: str) -> bool:
    """Return whether the files that a node reads are pictures."""
    param = graph.nodes[node].declaration.file_param
    return param is not None and param.pictures


def file_of(graph: Graph, node: str, values: Mapping[str, Any]) -> str:
    """Return the file or pattern that a read or write node is set to.

    Raises
    ------
    CommandError
        file-not-set, with the flag that sets it.
    """
    param = graph.nodes[node].declaration.file_param
    assert param is not None
    if not values.get(param.name):
        what, flag = ("read", "-i") if param.role == "input" else ("write", "-o")
        raise CommandError(
            f"no file to {what} is set",
            code="file-not-set",
            hint=f"{flag} FILE, or --set {node}.{param.name}=FILE",
            node=node,
            parameter=param.name,
        )
    return str(values[param.name])


def passed_over(graph: Graph) -> tuple[Note, ...]:
    """Return a warning for each node that reads a sequence, where its folder has files with numbers of other widths."""
    notes = []
    for node, sequence in _read_sequences(graph).items():
        if names := sequence.passed_over():
            shown = ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
            text = f"{len(names)} files are not frames of {os.path.basename(sequence.pattern)}: {shown}"
            notes.append(Note(f"{text}; widths are strict", node=node, warning=True))
    return tuple(notes)


def same_picture(graph: Graph, frames: int) -> tuple[Note, ...]:
    """Return a note where several frames are made and no node reads a sequence: all come from the same pictures."""
    sequences = _read_sequences(graph).values()
    if frames < 2 or not sequences or any(sequence.has_token for sequence in sequences):
        return ()
    names = list(dict.fromkeys(os.path.basename(sequence.pattern) for sequence in sequences))
    shown = ", ".join(names[:3]) + (" ..." if len(names) > 3 else "")
    what = "one picture" if len(names) == 1 else f"{len(names)} pictures"
    return (Note(f"all {frames} frames come from {what}, {shown}: a sequence has a token, such as ####"),)


def _read_sequences(graph: Graph) -> dict[str, Sequence]:
    """Return the sequence or single picture of each node that reads one and has it set, by the node's name."""
    values = graph.values(1)
    params = {name: node.declaration.file_param for name, node in graph.nodes.items()}
    return {
        node: Sequence.to_read(str(values[node][param.name]))
        for node, param in params.items()
        if param is not None and param.role == "input" and values[node].get(param.name)
    }


def source_contents(sources: Mapping[Unit, Source]) -> dict[Unit, str]:
    """Return what stands in each source, for its key.

    That is the hash of the file's content; before it "black " where the file only lends its windows to a black frame.

    Raises
    ------
    ReadError
        A file cannot be read; with node and frame.
    """
    found = {}
    for unit, source in sources.items():
        with error_boundary(unit.node, unit.frame):
            assert source.path is not None
            found[unit] = ("black " if source.black else "") + content_hash(source.path)
    return found
