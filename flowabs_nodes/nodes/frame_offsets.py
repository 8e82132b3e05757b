"""Asks a node which other frames of its inputs it reads, and holds the answer to the rules."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any

from flowabs_nodes.errors import FlowabsError, nearest
from flowabs_nodes.nodes.declare import Node

#: The most frames that a node may look before or after its own.
MAX_DISTANCE = 64


def frame_offsets(declaration: Node, params: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    """Return, for each input that a node reads on several frames, their offsets from its own frame, in order.

    ``params`` are all of the node's parameters, checked, lengths not scaled. A node without ``frames`` has no such
    input.

    Raises
    ------
    FlowabsError
        wrong-frames, where ``frames`` returns anything but a dict from names of declared inputs to different whole
        numbers from -64 to 64, 0 among them.
    """
    if declaration.frames is None:
        return {}
    asked = declaration.frames(dict(params))
    if not isinstance(asked, Mapping):
        raise _wrong(declaration, f"must return a dict from input to frame offsets, not {type(asked).__name__}")
    return {name: _checked(declaration, name, offsets) for name, offsets in asked.items()}


def _checked(declaration: Node, name: str, offsets: Any) -> tuple[int, ...]:
    """Return the offsets that are asked of one input, in order; raise FlowabsError where they break a rule."""
    inputs = [port.name for port in declaration.inputs]
    if name not in inputs:
        raise _wrong(declaration, f"names {name!r}, which is no input of the node", hint=nearest(name, inputs))
    where = f"for input {name!r}"
    if not isinstance(offsets, tuple | list | range):
        raise _wrong(declaration, f"must return a tuple of frame offsets {where}, not {type(offsets).__name__}")
    limit = f"at most {MAX_DISTANCE} frames before and after its own may be asked for"
    if len(offsets) > 2 * MAX_DISTANCE + 1:
        raise _wrong(declaration, f"asks for {len(offsets)} frames {where}: {limit}")
    whole = [_whole(declaration, offset, where) for offset in offsets]
    far = max(whole, key=abs, default=0)
    if abs(far) > MAX_DISTANCE:
        raise _wrong(declaration, f"asks for offset {far} {where}: {limit}")
    if len(set(whole)) < len(whole):
        twice = next(offset for offset in whole if whole.count(offset) > 1)
        raise _wrong(declaration, f"asks for offset {twice} twice {where}: each offset must be given once")
    if 0 not in whole:
        raise _wrong(declaration, f"does not ask for the node's own frame {where}: 0 must be among the offsets")
    return tuple(sorted(whole))


def _whole(declaration: Node, offset: Any, where: str) -> int:
    """Return an offset as an int; raise FlowabsError where it is no whole number."""
    try:
        if not isinstance(offset, bool):
            return operator.index(offset)
    except TypeError:
        pass
    raise _wrong(declaration, f"asks for offset {offset!r} {where}: offsets must be whole numbers")


def _wrong(declaration: Node, what: str, hint: str = "") -> FlowabsError:
    """Return the error of a node whose ``frames`` does ``what``."""
    return FlowabsError(f"frames() of {declaration.name} {what}", code="wrong-frames", hint=hint)
