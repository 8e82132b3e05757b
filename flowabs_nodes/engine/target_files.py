"""Checks the files that a run will write before its first frame: each is one frame's alone, and none is an input.

A sequence may have a million frames, so its folder is listed once; only names that stand there are followed through
links. A name that is not in its folder can be no link, and no other name of an input.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from functools import cache

from flowabs_nodes.errors import CommandError, WriteError
from flowabs_nodes.io import formats
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import Settings, checked
from flowabs_nodes.io.write_failure import check_access, check_writable


class RealNames:
    """Tells what file a path leads to, and looks into each folder once."""

    def __init__(self) -> None:
        self._real_folder = cache(lambda folder: os.path.join(os.path.realpath(folder), ""))
        self._names = cache(_folded_names)

    def look(self, path: str) -> tuple[str, bool]:
        """Return the path with every symbolic link followed, and False where no file has this name, capitals or not."""
        folder, name = os.path.split(path)
        if name.isascii() and name not in ("", ".", ".."):  # other letters some systems spell in two ways
            names = self._names(folder)
            if names is not None and name.casefold() not in names:
                return self._real_folder(folder) + name, False
        return os.path.realpath(path), True

    @staticmethod
    def identity(path: str) -> tuple[int, int] | None:
        """Return device and inode, which are the same for two names of one file; None where there is no file."""
        try:
            state = os.stat(path)
        except (OSError, ValueError):
            return None
        return state.st_dev, state.st_ino


def _folded_names(folder: str) -> frozenset[str] | None:
    """Return the names in a folder without capitals; None where it cannot be listed."""
    try:
        return frozenset(name.casefold() for name in os.listdir(folder or "."))
    except (FileNotFoundError, NotADirectoryError):
        return frozenset()
    except (OSError, ValueError):
        return None


def target_paths(
    outputs: list[Sequence], numbers: tuple[int, ...], settings: Settings, real_names: RealNames
) -> list[str]:
    """Return every file that will be written; raise CommandError where two outputs, or two frames, are one file.

    Raises
    ------
    CommandError
        no-frame-token, same-output, bad-path or outside-root.
    WriteError
        bad-format.
    """
    for sequence in outputs:
        formats.to_write(sequence.pattern)
        if len(numbers) > 1 and not sequence.has_token:
            raise CommandError(
                f"{len(numbers)} frames would go to one file",
                code="no-frame-token",
                hint="put #### where the frame number belongs",
                file=sequence.pattern,
            )
        checked(sequence.path(numbers[0]), settings)
    paths = [sequence.path(number) for number in numbers for sequence in outputs]
    seen: set[str] = set()
    for path in paths:
        real, there = real_names.look(path)
        if real in seen:
            raise CommandError("two outputs would be this one file", code="same-output", file=path)
        seen.add(real)
        if there:  # where no file has the name, it differs from the first by its number alone
            checked(path, settings)
    return paths


def refuse_inputs(
    targets: list[str],
    inputs: list[Sequence],
    numbers: tuple[int, ...],
    others: Iterable[str] = (),
    real_names: RealNames | None = None,
) -> None:
    """Raise CommandError where a file to write is, through any link, a file that the run reads.

    These are the files that any frame of ``inputs`` may have, and ``others``: the graph, the OCIO config.
    """
    names = real_names or RealNames()
    sources = set()
    identities = set()
    for path in (*_files_of(inputs, numbers), *filter(None, others)):
        real, there = names.look(path)
        sources.add(real)
        if there:
            identities.add(names.identity(path))
    identities.discard(None)
    for path in targets:
        real, there = names.look(path)
        if real in sources or (there and names.identity(path) in identities):
            raise CommandError("would be written over an input", code="output-is-input", file=path)


def _files_of(inputs: list[Sequence], numbers: tuple[int, ...]) -> Iterator[str]:
    """Yield every file that a frame of the inputs may have."""
    for sequence in inputs:
        if not sequence.has_token:
            yield sequence.pattern
            continue
        for number in {*numbers, *sequence.frames_on_disk()}:
            yield from sequence.paths(number)


def check_folders(targets: Iterable[str], *, touch: bool = True) -> None:
    """Raise CommandError where the folder of a file or pattern to write cannot be written to; it need not exist yet.

    It is tried with a file that is removed at once, or (``touch`` False) only the permissions are looked at.
    """
    for folder in sorted({os.path.dirname(path) or "." for path in targets}):
        try:
            (check_writable if touch else check_access)(folder)
        except WriteError as error:
            if error.code != "disk-full":  # that is the frames' business: some may be there already
                raise CommandError(error.message, code="unwritable-folder", file=folder) from error
