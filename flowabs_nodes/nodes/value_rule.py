"""Says which values a parameter takes, and judges values, here alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import cached_property
from typing import Any, Literal

from flowabs_nodes.errors import ArgumentError, nearest

Kind = Literal["float", "int", "bool", "enum", "string", "color", "file", "custom"]


@dataclass(frozen=True)
class ValueRule:
    """What a value of a parameter must be: its kind, hard range (an error beyond) and unit, or its choices.

    ``required`` parameters have no default. A custom kind has ``schema``, its JSON Schema, and ``parse``, which returns
    what is wrong with a value, or None.
    """

    name: str
    kind: Kind
    default: Any
    _: KW_ONLY
    min: float | None = None
    max: float | None = None
    above: bool = False  # the minimum itself is excluded
    unit: str = ""
    choices: tuple[str, ...] = ()
    nullable: bool = False
    required: bool = False
    schema: Mapping[str, Any] = field(default_factory=dict, hash=False)
    parse: Callable[[Any], str | None] | None = None

    def __repr__(self) -> str:
        default = "required" if self.required else f"default {self.default!r}"
        return f"<{type(self).__name__} {self.name}: {self.expected}; {default}>"

    @property
    def numeric(self) -> bool:
        """Return True for a number, which a map may drive, and a curve where it is ``animatable``."""
        return self.kind in ("float", "int")

    def problem(self, value: Any) -> tuple[str, str] | None:
        """Return None if ``value`` is good, else a code and what was expected.

        The code is "wrong-type", "bad-value" or "out-of-range".
        """
        if value is None and self.nullable:
            return None
        if self.parse is not None:
            wrong = self.parse(value)
            return ("bad-value", wrong) if wrong else None
        if not self._type_fits(value):
            return "wrong-type", self.expected
        if self.kind == "enum" and value not in self.choices:
            return "bad-value", self.expected
        if self.kind == "color" and not all(_is_finite(part) for part in value):
            return "bad-value", self.expected
        if self.numeric:
            if not _is_finite(value):
                return "bad-value", self.expected
            low = self.min is not None and (value < self.min or (self.above and value == self.min))
            if low or (self.max is not None and value > self.max):
                return "out-of-range", self.expected
        return None

    def _type_fits(self, value: Any) -> bool:
        match self.kind:
            case "float":
                return _is_number(value)
            case "int":
                return isinstance(value, int) and not isinstance(value, bool)
            case "bool":
                return isinstance(value, bool)
            case "color":
                return isinstance(value, list | tuple) and len(value) == 3 and all(_is_number(part) for part in value)
            case _:
                return isinstance(value, str)

    def check(self, value: Any) -> Any:
        """Return ``value`` in the type that ``run`` gets; raise ArgumentError, with the parameter, if it is wrong."""
        wrong = self.problem(value)
        if wrong:
            hint = nearest(value, self.choices) if self.kind == "enum" else ""
            raise ArgumentError(f"{value!r} is not {wrong[1]}", code=wrong[0], hint=hint, parameter=self.name)
        if value is None:
            return None
        match self.kind:
            case "float":
                return float(value)
            case "color":
                return tuple(float(part) for part in value)
            case _:
                return value

    @cached_property
    def expected(self) -> str:
        """Say what a value must be: "a number from 0 to 1, or null"."""
        words = {
            "float": "a number",
            "int": "a whole number",
            "bool": "true or false",
            "enum": "one of " + ", ".join(repr(choice) for choice in self.choices),
            "string": "a text",
            "color": "a colour: three finite numbers, scene-linear red, green, blue",
            "file": "a file name or sequence pattern",
            "custom": str(self.schema.get("description", "a value of its own kind")),
        }[self.kind]
        if self.min is not None or self.max is not None:
            words += " " + self.range_text
        if self.unit and self.numeric:
            words += f" ({self.unit})"
        return words + (", or null" if self.nullable else "")

    @cached_property
    def range_text(self) -> str:
        """Say the hard range: "from 0 to 1", "above 0 up to 100"; empty where there is none."""
        low = "" if self.min is None else f"{'above' if self.above else 'from'} {self.min:.10g}"
        high = "" if self.max is None else f"{'up to' if self.above or self.min is None else 'to'} {self.max:.10g}"
        return " ".join(part for part in (low, high) if part)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_finite(value: float) -> bool:
    """Return False for NaN, Inf, and an int too large for a float."""
    try:
        return math.isfinite(value)
    except OverflowError:
        return False
