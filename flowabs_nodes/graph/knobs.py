"""Reads the knobs of a graph's ``interface``, and says whether one may drive a parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from flowabs_nodes.graph import document_keys
from flowabs_nodes.graph.format import KNOB_TYPES, KnobType
from flowabs_nodes.graph.literals import check_literal, read_curve, whole_hint
from flowabs_nodes.graph.model import Knob
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.graph.values import Curve
from flowabs_nodes.nodes.declare import Param

#: The types of knobs that a parameter of each kind takes as they are. Of a ``custom`` parameter the value decides.
DRIVES: Mapping[str, tuple[KnobType, ...]] = {
    "float": ("float", "int"),
    "int": ("int",),
    "bool": ("bool",),
    "enum": ("enum",),
    "string": ("string", "enum"),
    "file": ("string", "enum"),
    "color": ("color",),
    "custom": KNOB_TYPES,
}


def read_knobs(interface: dict[str, Any], problems: Problems) -> dict[str, Knob | None]:
    """Return every knob by name; None for one that is wrong, about which nothing more is to be said."""
    place = ("interface",)
    entries = document_keys.read_named(interface, place, "a knob's name", problems)
    return {name: _read_knob(name, raw, (*place, name), problems) for name, raw in entries.items()}


def _read_knob(name: str, raw: Any, place: Place, problems: Problems) -> Knob | None:
    before = problems.errors
    knob = document_keys.read_fields(raw, place, document_keys.KNOB, problems, required=("type", "default"))
    kind = knob.get("type")
    if kind is not None and kind not in KNOB_TYPES:
        expected = f"one of {', '.join(KNOB_TYPES)}"
        problems.add("bad-value", (*place, "type"), show(kind), expected, problems.near(kind, KNOB_TYPES))
    if problems.errors > before or kind is None:
        return None
    for key in knob.keys() - _keys_of(kind):
        problems.add("unknown-key", (*place, key), f"{key!r} on a knob of type {kind}", _only_for(key))
    if kind == "enum":
        _check_choices(knob.get("choices"), (*place, "choices"), problems)
    if problems.errors > before:
        return None
    knob["choices"] = tuple(knob.get("choices", ()))
    made = _at_its_value(Knob(name, **knob), place, problems)
    return made if problems.errors == before else None


def _keys_of(kind: str) -> set[str]:
    own = {"float": {"min", "max"}, "int": {"min", "max"}, "enum": {"choices"}}.get(kind, set())
    return {"type", "default", "unit", "help", "label", "group"} | own


def _only_for(key: str) -> str:
    return "choices for an enum only" if key == "choices" else f"{key} for a float or an int only"


def _check_choices(choices: list[Any] | None, place: Place, problems: Problems) -> None:
    if not choices or not all(isinstance(choice, str) for choice in choices) or len(set(choices)) < len(choices):
        found = "nothing" if choices is None else show(choices)
        problems.add("bad-value", place, found, "a list of different words for an enum to choose from")


def _at_its_value(knob: Knob, place: Place, problems: Problems) -> Knob:
    """Return the knob with its curve, if its default is one.

    Checks the ends of the range against the knob's type and each other, then the default against the range.
    """
    free = replace(knob, min=None, max=None).param
    before = problems.errors
    for key in ("min", "max"):
        end = getattr(knob, key)
        wrong = None if end is None else free.problem(end)
        if wrong:
            hint = whole_hint(end) if knob.type == "int" else ""
            problems.add(wrong[0], (*place, key), show(end), wrong[1], hint)
    if problems.errors == before and knob.min is not None and knob.max is not None and knob.min > knob.max:
        problems.add("bad-value", (*place, "max"), show(knob.max), f"at least min, {knob.min:g}")
    judge, default, here = knob.param if problems.errors == before else free, knob.default, (*place, "default")
    if not isinstance(default, dict) or "curve" not in default:
        check_literal(judge, default, here, problems)
        return knob
    for key in default.keys() - {"curve"}:
        problems.add("unknown-key", (*here, key), f"{key!r} beside a curve", "curve alone")
    keys = read_curve(judge, default["curve"], (*here, "curve"), problems)
    return replace(knob, curve=Curve(keys, knob.type == "int"))


def check_drives(knob: Knob, param: Param, owner: str, place: Place, problems: Problems) -> None:
    """Check that a knob may drive a parameter as it is: its type fits, and so does every value it can take.

    ``place`` is the place of the parameter, ``owner`` its name in messages (``lines.sigma_c``). A value of the knob
    that does not fit is pointed at where the knob is declared.
    """
    if knob.type not in DRIVES[param.kind]:
        hint = "a map makes a whole number of it" if (param.kind, knob.type) == ("int", "float") else ""
        wanted = f"a knob of type {' or '.join(DRIVES[param.kind])}"
        problems.add("wrong-type", (*place, "from"), f"knob {knob.name!r} of type {knob.type}", wanted, hint)
        return
    values: list[tuple[Place, Any]] = [(("min",), knob.min), (("max",), knob.max)]
    if knob.curve is None:
        values.insert(0, (("default",), knob.default))
    else:
        values[:0] = [(("default", "curve", str(frame)), value) for frame, value in knob.curve.keys]
    values += [(("choices", i), choice) for i, choice in enumerate(knob.choices)]
    for key, value in values:
        wrong = None if value is None else param.problem(value)
        if wrong:
            problems.add(wrong[0], ("interface", knob.name, *key), show(value), f"{wrong[1]}, for {owner}")
            return  # the default, and the range it lies in, are one mistake


def check_moves(knob: Knob, param: Param, owner: str, problems: Problems) -> None:
    """Check that a knob with a curve drives a parameter that may change from frame to frame, as it is or by a map."""
    if knob.curve is not None and not param.animatable:
        place = ("interface", knob.name, "default", "curve")
        problems.add("wrong-type", place, "a curve", f"one value: {owner} is the same on every frame")
