"""Turns what Python code hands over into the plain data that a graph file would hold, under the same limits."""

from __future__ import annotations

import json
import os
from numbers import Real
from typing import Any

from flowabs_nodes.graph.problems import GraphError, Problem, Problems
from flowabs_nodes.graph.safe_json import parse


def jsonable(value: Any, problems: Problems) -> Any:
    """Return a copy of ``value`` as JSON would read it back: tuples as lists, NumPy numbers and paths as Python's.

    NumPy numbers may also be keys. Numbers that are not finite are problems at their place. Raises GraphError for what
    JSON cannot hold at all.
    """
    try:
        try:
            text = json.dumps(value, default=_default)
        except TypeError:  # perhaps a NumPy number as a key, which JSON's writer does not ask about
            text = json.dumps(_with_plain_keys(value), default=_default)
    except RecursionError:
        raise GraphError([Problem("too-big", "", "too many levels of nesting", "plain data")]) from None
    except (TypeError, ValueError) as error:
        expected = "plain data: dicts with text as keys, lists, texts, numbers, true, false, null"
        raise GraphError([Problem("wrong-type", "", str(error)[:200], expected)]) from None
    return parse(text.encode("ascii"), problems)


def _with_plain_keys(value: Any) -> Any:
    """Return a copy whose dicts have Python's numbers as keys where they had NumPy's."""
    if isinstance(value, dict):
        return {key.tolist() if hasattr(key, "tolist") else key: _with_plain_keys(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_with_plain_keys(item) for item in value]
    return value


def _default(value: Any) -> Any:
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):  # a numpy number or array
        plain = value.tolist()
        if type(plain) is not type(value):
            return plain
        if isinstance(plain, Real):  # a long double, of which Python has no like
            return float(plain)
    raise TypeError(f"{type(value).__name__} is not plain data")
