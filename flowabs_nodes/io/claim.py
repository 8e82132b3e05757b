"""Claim a frame before it is written, so that two runs never write one file, and publish it whole, in one step.

While the writer lives nobody else writes that frame. Where the writer is killed the next one removes what it left
(:mod:`flowabs_nodes.io.claim_watch`). The final name only ever holds a whole frame.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io import file_lock
from flowabs_nodes.io.claim_files import UNKNOWN, ClaimFile, Writer, claim_path, look, new_writer, temporary_path
from flowabs_nodes.io.claim_watch import ClaimWatch
from flowabs_nodes.io.confined import held_folder
from flowabs_nodes.io.file_lock import NOWHERE, reach
from flowabs_nodes.io.heartbeat import HEARTBEAT
from flowabs_nodes.io.write_failure import check_replaceable, failure
from flowabs_nodes.signals import before_the_end

_BLOCK = 1 << 24
#: How often a claim is tried for again, where those of the dead are in its way.
_ATTEMPTS = 5
#: The claims that this process holds.
_held: list[Claim] = []


class ClaimedError(WriteError):
    """Somebody else is writing this frame: ``writer`` says who."""

    code = "claimed"

    def __init__(self, final: Path, writer: Writer, what: str = "being written by another run, on") -> None:
        super().__init__(f"{what} {writer}" if writer != UNKNOWN else "being written by another run", file=str(final))
        self.writer = writer


class Claim:
    """The right to write one file: ``temporary`` is where its bytes go first.

    ``place`` leads to where ``final`` is: in a folder that is held, the same one wherever the name leads by now.
    """

    def __init__(self, final: Path, place: Path, writer: Writer, guard: ClaimFile, temporary: ClaimFile) -> None:
        self.final = final
        self._place = place
        self.writer = writer
        self._guard = guard
        self._temporary = temporary

    @property
    def temporary(self) -> Path:
        """Return the path of the temporary."""
        return self._temporary.path

    def write(self, data: bytes | memoryview) -> None:
        """Write every byte of ``data`` to the temporary; all are on disk when this returns. Raises OSError."""
        self._temporary.write(data)
        os.fsync(self._temporary.fd)

    def holds(self, data: bytes | memoryview) -> bool:
        """Read the temporary back, and return True if it is ``data``, byte for byte."""
        expected = memoryview(data)
        place = 0
        with open(self.temporary, "rb") as file:
            while block := file.read(_BLOCK):
                if expected[place : place + len(block)] != block:
                    return False
                place += len(block)
        return place == len(expected)

    def publish(self) -> None:
        """Give the temporary its final name, in one step; a symbolic link there is replaced, not followed.

        Raises ClaimedError where others took this writer for dead, after a minute without a sign of life, and one of
        them has the claim now; OSError.
        """
        _ = self._guard.fd  # raises in a process that was forked off: the claim is not its own
        found = look(self._guard.path)
        if found is None or found.writer != self.writer:
            taken = "taken over, after a minute without a sign of life, by another run, on"
            raise ClaimedError(self.final, found.writer if found else UNKNOWN, taken)
        HEARTBEAT.remove(self._temporary)  # its time is the frame's from now on
        if file_lock.fcntl is None:  # Windows renames no file that is open
            self._temporary.close()
        os.replace(self.temporary, self._place)
        _sync_folder(self._place.parent)

    def remove_files(self) -> None:
        """Remove what it has on disk, and nothing else: no lock is asked for."""
        for file in (self._temporary, self._guard):
            with suppress(OSError):
                os.unlink(file.path)

    def release(self) -> None:
        """Remove the temporary where it has not been published, and let others claim the frame."""
        for file in (self._temporary, self._guard):
            HEARTBEAT.remove(file)
        self._temporary.remove()
        found = look(self._guard.path)
        if found is not None and found.writer == self.writer:
            self._guard.remove()
        else:
            self._guard.close()


@contextmanager
def claim(path: str | os.PathLike[str], watch: ClaimWatch | None = None, root: Path | None = None) -> Iterator[Claim]:
    """Claim the file ``path``, and make its folder. The temporary is removed at the end unless it has been published.

    ``watch`` knows what its run has seen of other runs' claims; without one only a lock can show that a claim is dead.
    Within ``root`` the folder is held until the end (:func:`~flowabs_nodes.io.confined.held_folder`).

    Raises ClaimedError where somebody else is writing it, WriteError where its folder cannot be written, CommandError
    where it is not within ``root``.
    """
    final = Path(path)
    with ExitStack() as held:
        try:
            place = held.enter_context(held_folder(final.parent, root)) / final.name
            check_replaceable(place)
            taken = _take(final, place, watch or ClaimWatch())
        except OSError as error:
            raise failure(error, final) from error
        _held.append(taken)
        try:
            yield taken
        finally:
            _held.remove(taken)
            taken.release()


def _remove_files() -> None:
    """Remove the files of all claims of this process, which is about to end without notice."""
    for each in _held:
        each.remove_files()


before_the_end.append(_remove_files)


def _take(final: Path, place: Path, watch: ClaimWatch) -> Claim:
    """Make a claim. Raises ClaimedError where a living writer has one, OSError where the folder cannot be written."""
    for _ in range(_ATTEMPTS):
        if writer := watch.writer_of(final):
            raise ClaimedError(final, writer)
        try:
            return _made(final, place)
        except FileExistsError:  # somebody was faster
            continue
    raise ClaimedError(final, UNKNOWN)


def _made(final: Path, place: Path) -> Claim:
    """Make both files of a claim at ``place``. Raises FileExistsError where there is one, OSError."""
    with ExitStack() as undo:
        guard = ClaimFile(temporary_path(place, new_writer(reach(place.parent))))
        undo.callback(guard.remove)
        told = guard.locked and file_lock.is_locked(guard.path)
        writer = new_writer(reach(place.parent) if told else NOWHERE)
        guard.write(f"{writer.host} {writer.token} {writer.pid}\n".encode("ascii"))
        # Only now: of a claim that does not say whose it is nobody could tell that it is dead.
        guard.rename_new(claim_path(place))
        temporary = ClaimFile(temporary_path(place, writer))
        undo.callback(temporary.remove)
        for file in (guard, temporary):
            HEARTBEAT.add(file)
            undo.callback(HEARTBEAT.remove, file)
        taken = Claim(final, place, writer, guard, temporary)
        undo.pop_all()
        return taken


def _sync_folder(folder: Path) -> None:
    """Write a folder's entries to disk, where the system can: a rename then lasts through a power cut."""
    with suppress(OSError):
        fd = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(fd)
        finally:
            os.close(fd)
