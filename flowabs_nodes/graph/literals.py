"""Checks values that stand in a graph file as they are, alone or at the keys of a curve: a parameter's or a knob's."""

from __future__ import annotations

from typing import Any

from flowabs_nodes.graph.document_keys import NUMBER
from flowabs_nodes.graph.format import FRAME
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.nodes.declare import Param


def check_literal(param: Param, value: Any, place: Place, problems: Problems) -> None:
    """Add what is wrong with a value, with a hint."""
    wrong = param.problem(value)
    if wrong:
        hint = problems.near(value, param.choices) if param.choices else ""
        if param.kind in ("string", "file") and wrong[0] == "wrong-type":
            hint = f"a text stands in quotes: {_quoted(value)}" if isinstance(value, int | float) else ""
        if param.kind == "int" and wrong[0] == "wrong-type":
            hint = whole_hint(value)
        problems.add(wrong[0], place, show(value), wrong[1], hint)


def _quoted(value: Any) -> str:
    return show(show(value))


def whole_hint(value: Any) -> str:
    """Return what to write instead of 3.0 where a whole number belongs; nothing for any other value."""
    return f"write {int(value)}" if isinstance(value, float) and value.is_integer() and abs(value) < 2**53 else ""


def read_curve(param: Param, raw: Any, place: Place, problems: Problems) -> tuple[tuple[int, float], ...]:
    """Read the keys {"frame": value, ...} of a curve, in the order of the frames."""
    if not param.animatable:
        why = "this number is the same on every frame" if param.numeric else "only numbers take one"
        problems.add("wrong-type", place, "a curve", f"no curve: {why}; {param.expected}")
        return ()
    if not isinstance(raw, dict):
        problems.add("wrong-type", place, show(raw), 'an object from frame to value, such as {"1001": 0.98, "1100": 1}')
        return ()
    if not raw:
        problems.add("bad-value", place, "a curve without keys", "one key at least")
    keys = []
    for frame, value in raw.items():
        if not FRAME.fullmatch(frame):
            problems.add("bad-value", (*place, frame), show(frame), "a frame: a whole number of at most 9 digits")
        elif NUMBER.fits(value):
            check_literal(param, value, (*place, frame), problems)
            keys.append((int(frame), value))
        else:
            problems.add("wrong-type", (*place, frame), show(value), param.expected.removesuffix(", or null"))
    return tuple(sorted(keys))
