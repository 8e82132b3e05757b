"""Collects what is wrong with a graph: one :class:`Problem` for each mistake, all in one :class:`GraphError`."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Any

from flowabs_nodes.errors import FlowabsError, closest

#: The keys and indices that lead to a value of a document.
Place = tuple[str | int, ...]

#: Every code that a problem can have. The last three are warnings, the others are errors.
CODES = (
    "bad-json",
    "too-big",
    "newer-version",
    "unknown-key",
    "duplicate-key",
    "unknown-type",
    "unknown-param",
    "unknown-input",
    "unknown-output",
    "unknown-node",
    "missing-input",
    "missing-param",
    "wrong-type",
    "bad-value",
    "out-of-range",
    "cycle",
    "missing-package",
    "unused-node",
    "unused-param",
    "unused-knob",
)


@dataclass(frozen=True)
class Problem:
    """Describes one mistake in a graph file.

    Attributes
    ----------
    code
        One of :data:`CODES`.
    pointer
        The place, as a JSON Pointer (RFC 6901); of something missing, the place where it should be. A value that came
        with ``--set`` is pointed at as ``--set name``.
    found, expected
        What stands at that place and what should, in words.
    hint
        The nearest right name, or what to do; may be empty.
    warning
        True where the graph runs all the same.
    """

    code: str
    pointer: str
    found: str
    expected: str
    hint: str = ""
    warning: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return the problem as plain data, for ``--json``; ``warning`` is there only where it is true."""
        fields = {"code": self.code, "pointer": self.pointer, "found": self.found, "expected": self.expected}
        return {**fields, "hint": self.hint, **({"warning": True} if self.warning else {})}

    def __str__(self) -> str:
        hint = f" ({self.hint})" if self.hint else ""
        return f"{self.code} at {self.pointer or 'the top'}: found {self.found}, expected {self.expected}{hint}"

    @property
    def block(self) -> str:
        """Return the problem as several lines of text, for people."""
        rows = [f"{self.code}{' (warning)' if self.warning else ''}  {self.pointer or 'the whole file'}"]
        rows += [f"  found     {self.found}", f"  expected  {self.expected}"]
        if self.hint:
            rows.append(f"  hint      {self.hint}")
        return "\n".join(rows)


class GraphError(FlowabsError):
    """Says that a graph is not valid. ``problems`` holds everything that is wrong with it, warnings included."""

    code = "bad-graph"

    def __init__(self, problems: Iterable[Problem], *, file: str | None = None) -> None:
        self.problems = tuple(problems)
        count = sum(not problem.warning for problem in self.problems)
        blocks = "\n\n".join(problem.block for problem in self.problems)
        super().__init__(f"{count} {'problem' if count == 1 else 'problems'} in the graph\n\n{blocks}", file=file)

    def to_dict(self) -> dict[str, Any]:
        """Return the error as plain data, each problem by itself."""
        count = sum(not problem.warning for problem in self.problems)
        summary = {**super().to_dict(), "message": f"{count} {'problem' if count == 1 else 'problems'} in the graph"}
        return {**summary, "problems": [problem.to_dict() for problem in self.problems]}


class Problems:
    """Collects problems while a document is read.

    A place that is known to be wrong may be :meth:`silenced <silence>`, so that nothing that follows from it is
    reported. Memory and time stay bounded with a hostile file: one problem more than :attr:`most` raises GraphError,
    and names are compared for hints only as long as :attr:`comparisons` last.
    """

    most = 10_000
    comparisons = 12_000

    def __init__(self) -> None:
        self.found: list[Problem] = []
        self.errors = 0  # problems that are not warnings
        self._silent: set[Place] = set()

    def add(self, code: str, place: Place, found: str, expected: str, hint: str = "", *, warning: bool = False) -> None:
        """Add a problem, unless its place, or one above it, is silenced. A warning too many is left out."""
        if self._silent and any(place[:depth] in self._silent for depth in range(len(place) + 1)):
            return
        if warning and len(self.found) >= self.most:
            return
        self.room_for(1)
        self.errors += not warning
        self.found.append(Problem(code, pointer(place), found, expected, hint, warning))

    def room_for(self, count: int) -> None:
        """Raise GraphError if ``count`` problems more would be too many."""
        if len(self.found) + count > self.most:
            raise GraphError(
                [Problem("too-big", "", f"more than {self.most} problems", "fewer; the rest is not listed")]
            )

    def silence(self, place: Place) -> None:
        """Ignore problems at this place and below it from now on."""
        self._silent.add(place)

    def closest(self, name: object, known: Collection[str]) -> str | None:
        """Return the known name that ``name`` was probably meant to be; None if none is close."""
        self.comparisons -= len(known)
        return closest(name, known) if self.comparisons >= 0 else None

    def meant(self, name: object, unset: Collection[str], known: Collection[str]) -> tuple[str | None, str]:
        """Return which name of ``unset`` this one was probably meant to be, and a hint (from all known names)."""
        close = self.closest(name, unset)
        return close, f"did you mean {close!r}?" if close else self.near(name, known)

    def near(self, name: object, known: Collection[str]) -> str:
        """Return a hint: the closest known name, or all of them where none is close and they are few."""
        close = self.closest(name, known)
        if close is not None:
            return f"did you mean {close!r}?"
        return "known: " + ", ".join(known) if 0 < len(known) <= 24 else ""


def pointer(place: Place) -> str:
    """Return the place as a JSON Pointer (RFC 6901); "" is the whole document."""
    return "".join("/" + str(key).replace("~", "~0").replace("/", "~1") for key in place)


def show(value: Any) -> str:
    """Return a value as it stands in the file, shortened to fit a line."""
    if isinstance(value, dict):
        whole = json.dumps(value) if len(value) <= 4 and _flat(value.values()) else ""
        return whole if whole and len(whole) <= 80 else f"an object with {len(value)} keys"
    if isinstance(value, list):
        whole = json.dumps(value) if len(value) <= 8 and _flat(value) else ""
        return whole if whole and len(whole) <= 80 else f"a list of {len(value)}"
    return shortened(json.dumps(value[:200] if isinstance(value, str) else value, ensure_ascii=False), 80)


def shortened(text: str, most: int = 160) -> str:
    """Return a text of at most ``most`` letters: a longer one is cut."""
    return text if len(text) <= most else text[: most - 4] + " ..."


def _flat(values: Iterable[Any]) -> bool:
    return all(not isinstance(value, dict | list) and len(str(value)[:100]) < 60 for value in values)
