"""Watch the claims of other runs: which of them live, and remove those whose writer is dead.

Where locks reach, the lock says at once whether a writer lives. Elsewhere its file is touched every ten seconds, and a
writer is dead once the file's time has not changed for a minute, by the clock of whoever watches: the clocks of two
hosts are never compared, and process ids, which are all 1 in containers, say nothing.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io import file_lock
from flowabs_nodes.io.claim_files import (
    Found,
    Writer,
    burial_path,
    claim_path,
    is_burial,
    look,
    name_claimed,
    stem,
    temporary_path,
    writer_named,
)
from flowabs_nodes.io.file_lock import NOWHERE, reach
from flowabs_nodes.io.sequences import Sequence

#: Seconds without a change after which a claim counts as dead where its lock does not tell.
SILENCE = 60.0


class ClaimWatch:
    """What one run has seen of the claims of others, and since when none of them has changed.

    ``clock`` gives seconds and never goes back.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._seen: dict[Path, tuple[tuple[int, int, int], float]] = {}
        #: Temporaries that no claim names, by final name: of version 0.2.0, or of a writer that lost its claim.
        self._strays: dict[Path, list[Path]] = {}

    def writer_of(self, final: str | os.PathLike[str]) -> Writer | None:
        """Return who is writing a file; None where nobody is. Claims of the dead are removed on the way.

        Raises WriteError where something else has the name that a claim would have.
        """
        path = Path(final)
        guard = claim_path(path)
        found = look(guard)
        if found is not None:
            if not self._is_dead(guard, found) or not self._bury(path, found):
                return found.writer
        elif os.path.lexists(guard) and look(guard) is None:
            raise WriteError(
                f"{guard.name}, beside it, is no claim of a run, and has the name of one",
                code="claim-blocked",
                hint="remove it, or give it another name",
                file=str(path),
            )
        return self._stray_of(path)

    def sweep(self, folder: str | os.PathLike[str], *patterns: str, frames: Iterable[int] = ()) -> list[Path]:
        """Remove the claims and temporaries of dead writers of these file names or sequence patterns.

        The folder is listed once. Where a pattern's names are too long for a temporary to hold them, only those of
        ``frames`` are known. Returns what was removed.
        """
        place = Path(folder)
        try:
            entries = [entry for entry in os.listdir(place) if entry.startswith(".")]
        except OSError:
            return []
        sequences = [Sequence(os.path.basename(pattern)) for pattern in patterns]
        numbers = tuple(frames)
        long = {}
        for sequence in sequences:
            if stem(sequence.path(1)) != sequence.path(1):
                long.update({stem(full): full for full in map(sequence.path, numbers or (1,))})
        removed: list[Path] = []
        temporaries: list[tuple[Path, Path]] = []
        for entry in entries:
            name = name_claimed(entry)
            if name is None or not (name in long or any(each.frame_of(name) is not None for each in sequences)):
                continue
            path, final = place / entry, place / long.get(name, name)
            if writer_named(entry) or is_burial(entry):
                temporaries.append((final, path))
            elif (found := look(path)) and self._is_dead(path, found):
                temporary = temporary_path(final, found.writer)
                if self._bury(final, found):
                    removed += [path, *([temporary] if temporary.name in entries else [])]
        for final, path in temporaries:
            removed += self._sweep_temporary(final, path)
        return removed

    def _sweep_temporary(self, final: Path, path: Path) -> list[Path]:
        """Remove a temporary, or a burial, that no claim names and whose writer is dead; remember it where he lives."""
        found = look(path)
        claimed = look(claim_path(final))
        if found is None or (claimed and temporary_path(final, claimed.writer) == path):
            return []
        if self._is_dead(path, found):
            with suppress(OSError):
                path.unlink()
                return [path]
        elif not is_burial(path.name) and path not in self._strays.setdefault(final, []):
            self._strays[final].append(path)
        return []

    def _stray_of(self, final: Path) -> Writer | None:
        """Return who writes a temporary of ``final`` that no claim names; None where nobody does any more."""
        for path in list(self._strays.get(final, ())):
            self._sweep_temporary(final, path)
            found = look(path)
            if found is not None:
                return found.writer
            self._strays[final].remove(path)
        return None

    def _is_dead(self, path: Path, found: Found) -> bool:
        """Return True where the writer of a claim's file is surely gone."""
        if not is_burial(path.name) and found.writer.reach != NOWHERE and found.writer.reach == reach(path.parent):
            locked = file_lock.is_locked(path)
            if locked is not None:
                return not locked
        if found.writer.pid and found.writer.reach == NOWHERE and file_lock.is_locked(path):
            return False  # version 0.2.0 locked its temporaries, and touched none
        signature, since = self._seen.get(path, (None, 0.0))
        if signature != found.signature:
            self._seen[path] = (found.signature, self._clock())
            return False
        return self._clock() - since >= SILENCE

    def _bury(self, final: Path, found: Found) -> bool:
        """Remove a dead claim and its temporary. Return False where somebody else does, or has done, so.

        Of several that found one claim dead exactly one makes the burial's file. It looks again whether the claim is
        still that one, since another one's burial may be over, and a new claim be made.
        """
        burial = burial_path(final, found)
        try:
            fd = os.open(burial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666)
        except FileExistsError:
            self._sweep_temporary(final, burial)  # of one that died in the middle of it
            return False
        except OSError:
            return False
        try:
            if look(claim_path(final)) != found:
                return False
            with suppress(OSError):
                os.unlink(temporary_path(final, found.writer))
            os.unlink(claim_path(final))
        except OSError:
            return False
        finally:
            os.close(fd)
            with suppress(OSError):
                os.unlink(burial)
        self._seen.pop(claim_path(final), None)
        return True
