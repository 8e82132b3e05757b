"""Which keys each object of a graph file may have, and what kind of value each key takes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from flowabs_nodes.graph.format import LONGEST_NAME, NAME, NAME_RULE
from flowabs_nodes.graph.problems import Place, Problems, show


@dataclass(frozen=True)
class Kind:
    """Tells one kind of JSON value from the others: in words, as a test, and in JSON Schema."""

    words: str
    fits: Callable[[Any], bool]
    schema: Mapping[str, Any]


TEXT = Kind("a text", lambda value: isinstance(value, str), {"type": "string"})
NUMBER = Kind(
    "a number", lambda value: isinstance(value, int | float) and not isinstance(value, bool), {"type": "number"}
)
OBJECT = Kind("an object", lambda value: isinstance(value, dict), {"type": "object"})
LIST = Kind("a list", lambda value: isinstance(value, list), {"type": "array"})
ANY = Kind("a value", lambda value: True, {})

GRAPH: Mapping[str, Kind] = {
    "$schema": TEXT,
    "format": TEXT,
    "name": TEXT,
    "description": TEXT,
    "reference_size": OBJECT,
    "reference_height": NUMBER,
    "interface": OBJECT,
    "nodes": OBJECT,
    "ui": OBJECT,
}
NODE: Mapping[str, Kind] = {"type": TEXT, "inputs": OBJECT, "params": OBJECT}
KNOB: Mapping[str, Kind] = {
    "type": TEXT,
    "default": ANY,
    "min": NUMBER,
    "max": NUMBER,
    "choices": LIST,
    "unit": TEXT,
    "help": TEXT,
    "label": TEXT,
    "group": TEXT,
}


def read_fields(
    value: Any, place: Place, shape: Mapping[str, Kind], problems: Problems, required: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return the entries of an object that fit its ``shape``, by key.

    An unknown key, a value of the wrong kind (which is left out) and a ``required`` key that is missing are problems.
    An unknown key that is close to one that is not there is one mistake: the other is not reported as missing.
    """
    if not isinstance(value, dict):
        problems.add("wrong-type", place, show(value), f"an object with {', '.join(shape)}")
        return {}
    result = {}
    missing = [key for key in required if key not in value]
    for key, item in value.items():
        kind = shape.get(key)
        if kind is None:
            meant, hint = problems.meant(key, [name for name in shape if name not in value], shape)
            problems.add("unknown-key", (*place, key), show(key), "a key of the format", hint)
            missing = [name for name in missing if name != meant]
        elif kind.fits(item):
            result[key] = item
        else:
            problems.add("wrong-type", (*place, key), show(item), kind.words)
    for key in missing:
        problems.add("bad-value", (*place, key), "nothing", f"{key!r} is required")
    return result


def read_named(value: dict[str, Any], place: Place, what: str, problems: Problems) -> dict[str, Any]:
    """Return the entries of an object whose keys are names of ``what``.

    A bad name is a problem. Its entry stays, so that links to it are not wrong too, unless the name is too long.
    """
    for name in value:
        if not NAME.fullmatch(name):
            problems.add("bad-value", (*place, name), f"the name {show(name)}", f"{what}: {NAME_RULE}")
    return {name: item for name, item in value.items() if len(name) <= LONGEST_NAME}
