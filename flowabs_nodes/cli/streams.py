"""Makes stdout and stderr safe to print on, whatever is printed and whatever has become of them.

Inside :func:`safe_streams` every print of the program, click's help and messages included, goes through a
:class:`SafeStream`. A control character in a file's name cannot reach the terminal, and a stream that is closed, full
or read by nobody any more raises nothing: it is said once on stderr, and what else is printed is dropped.
"""

from __future__ import annotations

import errno
import io
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TextIO

#: What a terminal may obey, or show in another order than it is: control characters except tab and newline, marks of
#: the direction of writing, separators of lines; and the halves of pairs that Python puts for bytes that are no text.
_UNSAFE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    r"""Return a text with an escape, such as ``\x1b``, in place of each character that a terminal may obey.

    A byte of a file's name that is no UTF-8 becomes an escape too, ``\xff``.
    """
    return _UNSAFE.sub(lambda match: _escape(ord(match[0])), text)


def one_line(text: str) -> str:
    """Return a text as :func:`printable` does, newlines escaped too: a name cannot pretend to be a line of a log."""
    return printable(text).replace("\n", "\\n")


def _escape(code: int) -> str:
    if 0xDC80 <= code <= 0xDCFF:  # how Python holds the byte of a name that is no text
        code -= 0xDC00
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


class SafeStream(io.TextIOBase):
    """A stream that escapes what is printed, and drops it once it cannot be printed.

    Attributes
    ----------
    raw
        The stream behind, for who draws on a terminal; None where it was closed before the program began.
    trouble
        Why nothing can be printed any more, in words; "" as long as all is well.
    reader_left
        True where ``trouble`` is that whoever read the stream has ended, as ``head`` does.
    """

    def __init__(
        self, raw: TextIO | None, name: str, said_on: SafeStream | None = None, *, readers_may_leave: bool = False
    ) -> None:
        self.raw = raw
        self.trouble = ""
        self.reader_left = False
        self._name = name
        self._said_on = said_on
        self._readers_may_leave = readers_may_leave

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Return the encoding of the stream behind."""
        return getattr(self.raw, "encoding", None) or "utf-8"

    @property
    def errors(self) -> str:  # type: ignore[override]
        """Return what the stream behind does with letters that it does not have."""
        return getattr(self.raw, "errors", None) or "backslashreplace"

    def writable(self) -> bool:
        return True

    def isatty(self) -> bool:
        return not self.trouble and self.raw is not None and self.raw.isatty()

    def fileno(self) -> int:
        if self.raw is None:
            raise io.UnsupportedOperation("fileno")
        return self.raw.fileno()

    def write(self, text: str | bytes) -> int:
        count = len(text)
        if isinstance(text, bytes):  # click prints completions so
            text = text.decode(self.encoding, "surrogateescape")
        if not self.trouble:
            try:
                if self.raw is None:
                    raise OSError(errno.EBADF, "it is closed")
                self.raw.write(printable(text))
            except (OSError, ValueError) as error:
                self._drop(error)
        return count

    def flush(self) -> None:
        if not self.trouble and self.raw is not None:
            try:
                self.raw.flush()
            except (OSError, ValueError) as error:
                self._drop(error)

    def _drop(self, error: OSError | ValueError) -> None:
        """Say once that nothing can be printed any more, and see to it that what is left in a buffer harms nobody."""
        self.trouble = getattr(error, "strerror", None) or str(error)
        self.reader_left = isinstance(error, BrokenPipeError)
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self.fileno())
            os.close(nowhere)
        if self._said_on is not None and not (self.reader_left and self._readers_may_leave):
            print(f"flowabs: warning: {self._name} cannot be written: {self.trouble}", file=self._said_on, flush=True)


@contextmanager
def safe_streams(*, readers_may_leave: bool = False) -> Iterator[SafeStream]:
    """Put safe streams in the place of stdout and stderr inside; the one for stdout is handed over.

    ``readers_may_leave``: nothing is said where whoever reads stdout has seen enough.
    """
    before = sys.stdout, sys.stderr
    _occupy_descriptors()
    for stream in before:
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # an old terminal has few letters
    err = SafeStream(before[1], "stderr")
    out = SafeStream(before[0], "stdout", said_on=err, readers_may_leave=readers_may_leave)
    sys.stdout, sys.stderr = out, err
    try:
        yield out
    finally:
        sys.stdout, sys.stderr = before


def _occupy_descriptors() -> None:
    """Open nothing in the place of standard streams that are closed, or the next file opened, a frame, would be one."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            with suppress(OSError):
                os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
