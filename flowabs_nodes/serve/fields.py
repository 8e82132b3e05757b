"""Take values out of a request's JSON, each of the type that is expected there."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any, TypeVar

from flowabs_nodes.errors import CommandError, nearest

Value = TypeVar("Value")

_WORDS: dict[type, str] = {
    int: "a whole number",
    float: "a number",
    str: "a text",
    bool: "true or false",
    dict: "an object",
}
_NEEDED: Any = object()


class Fields:
    """Holds an object of JSON, at a ``place`` of a request: "given.plate"; "" is the request itself."""

    def __init__(self, values: Any, place: str, known: Collection[str]) -> None:
        """Take the object. Raises CommandError where it is none, and for keys that are not ``known``."""
        self.place = place
        if not isinstance(values, dict):
            raise self._wrong("", "an object", values)
        self.values: Mapping[str, Any] = values
        unknown = next((key for key in values if key not in known), None)
        if unknown is not None:
            raise CommandError(
                f"{self._name(unknown)}: no such key",
                code="unknown-key",
                hint=nearest(unknown, known),
                parameter=self._name(unknown),
            )

    def get(self, key: str, kind: type[Value], default: Value = _NEEDED) -> Value:
        """Return a value of a type; ``default`` where it is missing or null. Raises CommandError for others."""
        value = self.values.get(key)
        if value is None:
            if default is _NEEDED:
                raise self._wrong(key, _WORDS[kind], None)
            return default
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(min(max(value, -(2**1000)), 2**1000))  # an int may be beyond what a float holds
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise self._wrong(key, _WORDS[kind], value)
        return value

    def count(self, key: str, least: int, most: int, default: int = _NEEDED) -> int:
        """Return a whole number from ``least`` to ``most``."""
        value = self.get(key, int, default)
        if value is not default and not least <= value <= most:
            raise self._wrong(key, f"{least} to {most}", value)
        return value

    def word(self, key: str, known: Collection[str], default: str = _NEEDED) -> str:
        """Return one of the words that are known."""
        value = self.get(key, str, default)
        if value not in known:
            raise self._wrong(key, " or ".join(map(repr, known)), value, nearest(value, known))
        return value

    def numbers(self, key: str, count: int) -> tuple[int, ...] | None:
        """Return a list of ``count`` whole numbers, each within 31 bits; None where it is missing or null."""
        value = self.values.get(key)
        if value is None:
            return None
        fits = isinstance(value, list) and len(value) == count
        if not fits or not all(type(each) is int and abs(each) < 2**31 for each in value):
            raise self._wrong(key, f"{count} whole numbers", value)
        return tuple(value)

    def _name(self, key: str) -> str:
        return ".".join(filter(None, (self.place, key)))

    def _wrong(self, key: str, expected: str, found: Any, hint: str = "") -> CommandError:
        """Return the error of a value that is missing or wrong."""
        name = self._name(key) or "request"
        what = "nothing" if found is None else repr(found)[:80]
        return CommandError(f"{name}: expected {expected}, found {what}", code="bad-request", hint=hint, parameter=name)
