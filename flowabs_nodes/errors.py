"""Defines the one exception family: each error says where, what was found and expected, and the nearest right name."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from typing import Any


class FlowabsError(Exception):
    """Base of every error that flowabs raises on purpose.

    Parameters
    ----------
    message
        What was found and what was expected, in one sentence.
    code
        Stable machine-readable word, such as ``"read-failed"``; each subclass has its own default.
    hint
        What to try: usually the nearest right name.
    file, frame, node, parameter
        Where it happened, as far as it is known. A caller that knows more adds it with :meth:`at`.
    """

    code = "error"

    def __init__(
        self,
        message: str,
        *,
        code: str | None = None,
        hint: str = "",
        file: str | None = None,
        frame: int | None = None,
        node: str | None = None,
        parameter: str | None = None,
    ) -> None:
        super().__init__(message)
        self.message = message
        if code is not None:
            self.code = code
        self.hint = hint
        self.file = file
        self.frame = frame
        self.node = node
        self.parameter = parameter

    def at(self, *, file: str | None = None, frame: int | None = None, node: str | None = None) -> FlowabsError:
        """Add what is not known yet of the place, and return the same error (``raise error.at(node="flow")``)."""
        self.file = self.file if self.file is not None else file
        self.frame = self.frame if self.frame is not None else frame
        self.node = self.node if self.node is not None else node
        return self

    def __str__(self) -> str:
        place = [f"{self.file}"] if self.file is not None else []
        place += [f"frame {self.frame}"] if self.frame is not None else []
        return ": ".join([*place, self.reason])

    @property
    def reason(self) -> str:
        """Return node, parameter, message and hint: what several frames may have in common."""
        # A message may begin with a name itself: said once is enough.
        node = "" if self.message.startswith(f"node {self.node!r} ") else self.node
        parameter = "" if re.match(rf"{re.escape(str(self.parameter))}(?!\w)", self.message) else self.parameter
        place = [f"node {node}" if node else "", f"parameter {parameter}" if parameter else ""]
        text = ": ".join([*filter(None, place), self.message])
        return f"{text} ({self.hint})" if self.hint else text

    def __reduce__(self) -> tuple[Any, ...]:
        """Let an error travel to another process as what it is, without its cause, whatever its class is made from."""
        return _remade, (type(self), self.args), self.__dict__

    def to_dict(self) -> dict[str, Any]:
        """Return the error as plain data, for ``--json``; keys without a value are left out."""
        fields = {
            "code": self.code,
            "message": self.message,
            "hint": self.hint or None,
            "file": self.file,
            "frame": self.frame,
            "node": self.node,
            "parameter": self.parameter,
        }
        return {key: value for key, value in fields.items() if value is not None}


def _remade(kind: type[FlowabsError], arguments: tuple[object, ...]) -> FlowabsError:
    """Return an error of a class; its attributes are set afterwards."""
    error = kind.__new__(kind, *arguments)
    error.args = arguments
    return error


class ArgumentError(FlowabsError, ValueError):
    """A function's argument breaks a rule: names the argument (``parameter``), the rule and the value."""

    code = "bad-value"


class ColorError(FlowabsError):
    """A colour space is unknown, not usable here, or its OCIO config cannot be read."""

    code = "bad-colorspace"


class ReadError(FlowabsError):
    """A picture cannot be read: missing, damaged, of another format, too large, or without the channels asked for."""

    code = "read-failed"


class WriteError(FlowabsError):
    """A picture cannot be written whole; nothing is left at its final name."""

    code = "write-failed"


class CommandError(FlowabsError):
    """The command, or a call of ``run``, asks for something that cannot be done at all (exit code 2)."""

    code = "bad-command"


class Cancelled(FlowabsError):
    """A session's run was cancelled; no failure, and nothing is lost."""

    code = "cancelled"


class InternalError(FlowabsError):
    """An exception that nobody foresaw was raised: a fault of the node, of this package, or of the machine.

    That exception is ``__cause__``. Codes: "internal", or "out-of-memory".
    """

    code = "internal"


def unforeseen(error: BaseException) -> InternalError:
    """Return the InternalError that stands for an exception which nobody foresaw; the caller raises it from that one.

    Its message is one line. Of what is no Exception, such as SystemExit, it says that it was meant for the process.
    """
    first_line = (str(error).strip().splitlines() or [""])[0][:300]
    said = f"{type(error).__name__}: {first_line}"
    if isinstance(error, Exception):
        return InternalError(said)
    return InternalError(
        f"it tried to end the whole process ({said.removesuffix(': ')})",
        hint="a node that cannot go on raises an Exception, and only its frame fails",
    )


def closest(name: object, known: Iterable[str]) -> str | None:
    """Return the known name that ``name`` was probably meant to be; None if none is.

    Case, leading zeros, and whether words are joined by "_", "-" or a space, make no difference. A name that begins
    with ``name`` goes before one that is as near in another way.
    """
    names: dict[str, str] = {}
    for each in known:
        names.setdefault(_plain(each), each)
    plain = _plain(str(name)[:200])
    begun = [each for each in names if each.startswith(plain)]
    close = difflib.get_close_matches(plain, begun, 1) or difflib.get_close_matches(plain, names, 1)
    return names[close[0]] if close else None


def _plain(name: str) -> str:
    """Return a name in lower case, its words joined by "_", its numbers without leading zeros: fig_1 for Fig-01."""
    return re.sub(r"(?<!\d)0+(?=\d)", "", re.sub(r"[-_ ]+", "_", name.lower()))


def nearest(name: object, known: Iterable[str]) -> str:
    """Return a hint for a name that is not known: the nearest right name, or all names where none is near."""
    names = sorted(set(known))
    return likely(name, names) or ("known: " + ", ".join(names) if names else "")


def likely(name: object, known: Iterable[str]) -> str:
    """Return a hint for a name that is not known, the nearest right one; empty where none is near."""
    close = closest(name, known)
    return "" if close is None else f"did you mean {close!r}?"
