"""Memory that a client made and this process sees too: a file of the client, or on Windows a mapping by name."""

from __future__ import annotations

import mmap
import os
import stat
import sys

from flowabs_nodes.errors import CommandError

#: Pixels of 16 bytes: how often ``max_pixels`` of them fit into one memory, for a plate, others beside it, and results.
PICTURES = 8


class SharedMemory:
    """Memory that both processes read and write.

    Attributes
    ----------
    view
        The mapping, which NumPy makes arrays of. It is let go with the last array.
    bytes
        How many there are.
    """

    def __init__(self, view: mmap.mmap, bytes: int) -> None:
        self.view, self.bytes = view, bytes

    def check(self) -> None:
        """Raise CommandError where the client has made its file shorter: to touch what is gone would end us."""
        if sys.platform != "win32" and self.view.size() < self.bytes:
            raise CommandError(
                f"memory: expected {self.bytes} bytes, found {self.view.size()}", code="bad-memory", parameter="memory"
            )


def most_bytes(max_pixels: int) -> int:
    """Return how many bytes one memory, or one message's payload, may have."""
    return PICTURES * 16 * max_pixels


def opened_file(path: str, bytes: int) -> SharedMemory:
    """Map the first ``bytes`` of a client's file; its name is not needed any more afterwards.

    Raises
    ------
    CommandError
        No plain file of this user alone, a symbolic link, a file that is shorter, or not on this system.
    """
    if os.name == "nt":  # a name is for Windows
        raise CommandError("path: memory has a name on Windows, no path", code="bad-memory", parameter="path")
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise _unusable(path, getattr(error, "strerror", None) or str(error)) from None
    try:
        found = os.fstat(descriptor)
        if not stat.S_ISREG(found.st_mode):
            raise _unusable(path, "expected a plain file")
        if found.st_uid != os.geteuid() or found.st_mode & 0o077:
            raise _unusable(path, f"expected a file of this user alone, 0600, found {found.st_mode & 0o777:04o}")
        if found.st_size < bytes:
            raise _unusable(path, f"expected {bytes} bytes, found {found.st_size}")
        return SharedMemory(mmap.mmap(descriptor, bytes), bytes)
    except (OSError, ValueError, OverflowError) as error:
        raise _unusable(path, getattr(error, "strerror", None) or str(error)) from None
    finally:
        os.close(descriptor)


def opened_name(name: str, bytes: int) -> SharedMemory:
    """Map the first ``bytes`` of a mapping by its name (Windows). Raises CommandError where there is none."""
    if sys.platform == "win32":
        import ctypes  # Python's own mmap would make a mapping of a name that is not there

        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        kernel.OpenFileMappingW.restype = ctypes.c_void_p
        there = kernel.OpenFileMappingW(0x0002 | 0x0004, False, name)  # to write and to read
        if not there:
            raise _unusable(name, f"no such mapping (error {ctypes.get_last_error()})")
        try:
            return SharedMemory(mmap.mmap(-1, bytes, tagname=name), bytes)
        except (OSError, ValueError, OverflowError) as error:
            raise _unusable(name, str(error)) from None
        finally:
            kernel.CloseHandle(ctypes.c_void_p(there))
    raise CommandError("name: memory has a path on this system", code="bad-memory", parameter="name")


def _unusable(name: str, why: str) -> CommandError:
    """Return the error of memory that cannot be used."""
    return CommandError(f"memory: {why}", code="bad-memory", file=name, parameter="memory")
