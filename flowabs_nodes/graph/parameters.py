"""Reads what a graph sets a parameter to: a literal, ``{"from": knob}`` (perhaps with a map), or ``{"curve": ...}``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes.graph.document_keys import NUMBER
from flowabs_nodes.graph.knobs import check_drives, check_moves
from flowabs_nodes.graph.literals import check_literal, read_curve
from flowabs_nodes.graph.model import Knob
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.graph.values import Curve, FromKnob, Literal, Value
from flowabs_nodes.nodes.declare import Param


def read_value(
    param: Param, raw: Any, knobs: Mapping[str, Knob | None], owner: str, place: Place, problems: Problems
) -> Value | None:
    """Return the parameter's value, or None where it is wrong. ``owner`` is its name in messages (``lines.rho``)."""
    before = problems.errors
    value: Value
    if isinstance(raw, dict) and ("from" in raw or "curve" in raw or param.kind != "custom"):
        if not _shape_fits(raw, param, place, problems):
            return None
        if "curve" in raw:
            value = Curve(read_curve(param, raw["curve"], (*place, "curve"), problems), param.kind == "int")
        else:
            value = _from_knob(param, raw, knobs, owner, place, problems)
    else:
        check_literal(param, raw, place, problems)
        value = Literal(raw)
    return value if problems.errors == before else None


def _shape_fits(raw: dict[str, Any], param: Param, place: Place, problems: Problems) -> bool:
    """Check the keys of a reference: one of ``from`` and ``curve``, ``map`` beside ``from`` only, nothing else."""
    fits = True
    for key in raw.keys() - {"from", "map", "curve"}:
        hint = problems.near(key, ("from", "map", "curve"))
        problems.add(
            "unknown-key", (*place, key), show(key), f"{param.expected}; or an object with from or curve", hint
        )
        fits = False
    if fits and not ("from" in raw) ^ ("curve" in raw):
        found = "both from and curve" if raw.keys() >= {"from", "curve"} else show(raw)
        problems.add("bad-value", place, found, f"{param.expected}; or an object with from or curve")
        return False
    if fits and "map" in raw and "from" not in raw:
        problems.add("unknown-key", (*place, "map"), "'map' beside a curve", "map beside from only")
        return False
    return fits


def _from_knob(
    param: Param, raw: dict[str, Any], knobs: Mapping[str, Knob | None], owner: str, place: Place, problems: Problems
) -> FromKnob:
    name = raw["from"]
    knob = None
    if not isinstance(name, str):
        problems.add("wrong-type", (*place, "from"), show(name), "the name of a knob")
    elif name not in knobs:
        problems.add("unknown-param", (*place, "from"), show(name), "a knob of this graph", problems.near(name, knobs))
    else:
        knob = knobs[name]
    if "map" not in raw:
        if knob is not None:
            check_drives(knob, param, owner, place, problems)
            check_moves(knob, param, owner, problems)
        return FromKnob(str(name))
    if not param.numeric:
        problems.add("wrong-type", (*place, "map"), "a map", f"no map: only numbers take one; {param.expected}")
    elif knob is not None and knob.type not in ("float", "int"):
        problems.add(
            "wrong-type", (*place, "from"), f"knob {name!r} of type {knob.type}", "a knob of type float or int"
        )
    elif knob is not None:
        check_moves(knob, param, owner, problems)
    points = _map(param, raw["map"], (*place, "map"), problems) if param.numeric else ()
    return FromKnob(str(name), points, param.kind == "int")


def _map(param: Param, raw: Any, place: Place, problems: Problems) -> tuple[tuple[float, float], ...]:
    """Read the points [[x, y], ...] of a map: x increasing, y good for the parameter."""
    if not isinstance(raw, list):
        problems.add("wrong-type", place, show(raw), "a list of [x, y] points")
        return ()
    if len(raw) < 2:
        problems.add("bad-value", place, show(raw), "a list of two points [x, y] at least")
        return ()
    points: list[tuple[float, float]] = []
    for i, point in enumerate(raw):
        if not isinstance(point, list) or len(point) != 2 or not NUMBER.fits(point[0]):
            problems.add("wrong-type", (*place, i), show(point), "a point [x, y] of two numbers")
            continue
        x, y = point
        if points and x <= points[-1][0]:
            problems.add("bad-value", (*place, i, 0), show(x), f"x greater than the point before's, {points[-1][0]:g}")
        if NUMBER.fits(y):
            check_literal(param, y, (*place, i, 1), problems)
            points.append((x, y))
        else:
            problems.add("wrong-type", (*place, i, 1), show(y), param.expected)
    return tuple(points)
