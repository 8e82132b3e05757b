"""Decides what becomes of an output file that is there already: it stays, it is made again, or it is not this run's."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import NamedTuple

from flowabs_nodes.engine.report import Note
from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.provenance import Stamp, stored_stamp
from flowabs_nodes.io.verify import flaw
from flowabs_nodes.io.write_failure import check_replaceable

_CURE = "--existing overwrite replaces it"

#: What changes when a file is written again: (device, inode, time of change in ns, size). None: there is no file.
State = tuple[int, int, int, int] | None


class Origin(NamedTuple):
    """What this run would stamp its files with, beside their keys: the graph's name and the scale."""

    graph: str
    scale: float


def state_of(path: str | os.PathLike[str]) -> State:
    """Return what changes when a file is written again."""
    try:
        state = os.lstat(path)
    except (OSError, ValueError):
        return None
    return state.st_dev, state.st_ino, state.st_mtime_ns, state.st_size


def is_stale(path: str, key: str, origin: Origin, existing: str, notes: list[Note]) -> bool:
    """Return True where a file has to be written; ``notes`` are told why one that is there is made again.

    ``existing`` is the option of :class:`~flowabs_nodes.engine.options.RunOptions`. With "resume" a file stays if it
    carries this key, all its pixels decode, and they are those that were written. One with another key is made again
    if it is of the same graph, by name (two graphs without a name count as one), and of the same scale.

    Raises
    ------
    WriteError
        exists or foreign-file, where a file is in the way; not-a-file for a pipe, a device or a folder.
    """
    if not os.path.lexists(path):
        return True
    check_replaceable(path)
    if existing == "overwrite":
        return True
    if existing == "error":
        raise exists(path)
    found = stored_stamp(path)
    if found is None or found.key != key:
        if why := foreign(found, origin):
            raise not_ours(path, why)
        notes.append(Note(f"made again, {path} is of other parameters, another plate or version"))
        return True
    wrong = flaw(path, found.pixels)
    if wrong:
        what = "is damaged" if wrong == "damaged" else "has other pixels than were written"
        notes.append(Note(f"made again, {path} {what}"))
    return bool(wrong)


def made_since(path: str, key: str, before: Mapping[str, State]) -> bool:
    """Return True if a whole file of this key has been written since its state was the one in ``before``."""
    if path not in before or state_of(path) == before[path]:
        return False
    found = stored_stamp(path)
    return found is not None and found.key == key and not flaw(path, found.pixels)


def exists(path: str) -> WriteError:
    """Return the error of a file that is there, with ``--existing error``."""
    hint = "--existing resume goes on where a run stopped, overwrite replaces"
    return WriteError("exists already", code="exists", hint=hint, file=path)


def not_ours(path: str, why: str) -> WriteError:
    """Return the error of a file that is not this run's to replace."""
    return WriteError(f"exists already and {why}", code="foreign-file", hint=_CURE, file=path)


def foreign(found: Stamp | None, origin: Origin) -> str:
    """Return why a file with this stamp is not this run's to replace; "" where it is."""
    if found is None:
        return "cannot be read: damaged or cut short in its header, or no picture, so nothing says who wrote it"
    if not found.key:
        return "was not written by flowabs"
    if found.graph is not None and found.graph != origin.graph:
        return f"was made by {_named(found.graph)}, not by {_named(origin.graph)}"
    if found.scale is not None and found.scale != origin.scale:
        return f"was made with --scale {found.scale:g}, not {origin.scale:g}"
    return ""


def _named(graph: str) -> str:
    """Return a graph's name as it stands in a sentence."""
    return f"the graph {graph!r}" if graph else "a graph without a name"
