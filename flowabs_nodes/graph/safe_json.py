"""Reads JSON that may be hostile: bounded in size, nesting and number of values, no key twice, finite numbers only.

What Python's json module would let through (NaN, 1e999, repeated keys, half of a surrogate pair) is reported with its
place. What would exhaust it (200,000 levels, millions of values) is refused before it is parsed.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterable
from typing import Any

from flowabs_nodes.graph.problems import GraphError, Place, Problem, Problems, show

MOST_BYTES = 8 * 2**20
MOST_LEVELS = 64
MOST_DIGITS = 300  # in a whole number: about what a float can hold; Python refuses to convert more than 4300
#: 40 for each of 10,000 nodes. 8 MB have room for millions, and the smallest takes 60 bytes of memory.
MOST_VALUES = 400_000

#: Anything up to the next bracket or comma outside strings. Possessive, and matching at the end too: linear in time.
_UP_TO_NEXT = re.compile(rb'(?:[^"\[\]{},]++|"(?:[^"\\]++|\\.)*+"?)*+([\[\]{},]?)', re.DOTALL)
_LONG_NUMBER = re.compile(rb"(?<![0-9])[0-9]{%d}" % MOST_DIGITS)
_SUSPICIOUS_ESCAPE = re.compile(rb"\\u(?:[dD][89a-fA-F]|0000)")
_UNFIT = re.compile("[\0\ud800-\udfff]")


class _Wrong:
    """Stands in the parsed document in place of a number that is not finite, or has too many digits."""

    def __init__(self, text: str) -> None:
        self.text = text


def parse(data: bytes, problems: Problems) -> Any:
    """Return the document that JSON text holds.

    NaN, infinite numbers, repeated keys and characters that no name or path can hold become problems at their place,
    which is silenced; the rest of the document stands. Anything else wrong raises GraphError.
    """
    text = _refuse(data)
    repeated: list[tuple[dict[str, Any], str]] = []
    wrong: list[_Wrong] = []

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        result = dict(items)
        if len(result) < len(items):
            counts = Counter(key for key, _ in items)
            repeated.extend((result, key) for key, times in counts.items() if times > 1)
            problems.room_for(len(repeated))
        return result

    def constant(name: str) -> _Wrong:
        wrong.append(_Wrong(name))
        problems.room_for(len(wrong))
        return wrong[-1]

    def real(digits: str) -> float | _Wrong:
        value = float(digits)
        return value if math.isfinite(value) else constant(digits)

    def whole(digits: str) -> int | _Wrong:
        return int(digits) if len(digits) <= MOST_DIGITS else constant(digits)

    integer = whole if _LONG_NUMBER.search(data) else None  # seldom needed, and slow
    try:
        document = json.loads(
            text, object_pairs_hook=pairs, parse_constant=constant, parse_float=real, parse_int=integer
        )
    except json.JSONDecodeError as error:
        found = f"{error.msg} (line {error.lineno}, column {error.colno})"
        raise _refusal("bad-json", found, "JSON (RFC 8259)", "look at commas, quotes and brackets there") from None
    if repeated or wrong or _SUSPICIOUS_ESCAPE.search(data):
        document = _inspect(document, repeated, problems)
    return document


def _refuse(data: bytes) -> str:
    """Return the text if it is safe to hand to the parser; raise GraphError if not."""
    if len(data) > MOST_BYTES:
        raise _refusal("too-big", "more than 8 MB", "at most 8 MB")
    try:
        text = data.decode("utf-8-sig")  # a byte order mark is let pass
    except UnicodeDecodeError as error:
        raise _refusal("bad-json", f"byte {data[error.start]:#04x} at {error.start}", "UTF-8 text") from None
    level = values = 0
    for match in _UP_TO_NEXT.finditer(data):
        if match[1] in (b"]", b"}"):
            level -= 1
            if level < 0:
                break  # the parser will say where
            continue
        values += 1
        level += match[1] in (b"[", b"{")
        if level > MOST_LEVELS:
            raise _refusal("too-big", f"more than {MOST_LEVELS} levels of nesting", f"at most {MOST_LEVELS}")
        if values > MOST_VALUES:
            raise _refusal("too-big", f"more than {MOST_VALUES} values", f"at most {MOST_VALUES}")
    return text


def _refusal(code: str, found: str, expected: str, hint: str = "") -> GraphError:
    return GraphError([Problem(code, "", found, expected, hint)])


def _inspect(document: Any, repeated: list[tuple[dict[str, Any], str]], problems: Problems) -> Any:
    """Report what the parser noticed at its place. A wrong number becomes 0, so that the rest can be checked."""
    keys: dict[int, list[str]] = {}
    for owner, key in repeated:
        keys.setdefault(id(owner), []).append(key)
    top = [document]
    todo: list[tuple[Place, Any]] = [((), top)]
    while todo:
        above, owner = todo.pop()
        for key in keys.get(id(owner), ()):
            problems.add("duplicate-key", (*above, key), f"{show(key)} more than once", "each key once")
        items: Iterable[tuple[Any, Any]] = enumerate(owner) if isinstance(owner, list) else list(owner.items())
        for key, value in items:
            place = () if owner is top else (*above, key)
            if isinstance(key, str) and not _fit(key, above, problems):
                continue
            if isinstance(value, dict | list):
                todo.append((place, value))
            elif isinstance(value, str):
                _fit(value, place, problems)
            elif isinstance(value, _Wrong):
                problems.add("bad-json", place, show(value.text)[1:-1], "a finite number that fits 64 bits")
                problems.silence(place)
                owner[key] = 0
    return top[0]


def _fit(text: str, place: Place, problems: Problems) -> bool:
    """Return True if the text can be printed, stored and used as a path; report it if not."""
    if not _UNFIT.search(text):
        return True
    shown = re.sub(r"\\udc([89a-f][0-9a-f])", r"\\x\1", ascii(text[:60]))  # the byte of a file's name that is no text
    problems.add("bad-json", place, shown, "text: a name in another encoding than UTF-8, or with NUL, cannot be here")
    problems.silence(place)
    return False
