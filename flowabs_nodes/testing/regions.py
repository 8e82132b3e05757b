"""Checks a node's region: the crop that it asks for gives the bits of the whole picture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

import numpy as np

from flowabs_nodes.engine.call_node import check_params
from flowabs_nodes.engine.error_boundary import InternalError
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import PORT_TYPES, Image, PortType, Window
from flowabs_nodes.nodes.declare import MASK, MIX, Node
from flowabs_nodes.simd import bands
from flowabs_nodes.testing.parameters import alternatives
from flowabs_nodes.testing.pictures import SCENES, make_input
from flowabs_nodes.testing.running import inputs_of, require, run_node

#: The farthest reach that is tried, and how much larger a picture gets by it, in pixels. Of most windows of a picture
#: of this size a region with more reach is the whole.
_FAR, _LARGE = 80, 110

Settings = Mapping[str, Any]


def works_on_a_region(node: Node) -> None:
    """Check that each output on a window is the same, bit for bit, from the crop to the node's region.

    Windows lie at corners, at edges and inside, some a pixel, a row or a column large, one the whole picture. Crops are
    filtered on one thread and on two, by turns. Beside the defaults each parameter is changed, on fewer pictures and
    windows.
    """
    found = _settings(node)
    for scene in SCENES:
        for kinds in _kinds(node):
            _compare(node, scene, kinds, found[0])
        if node.mixes:
            _compare(node, scene, {}, {**found[0], MIX.name: 0.75}, mask=True)
    for i, settings in enumerate(found[1:]):
        for scene in ("noise", "alpha"):
            _compare(node, scene, {}, settings, some=slice(i % 3, None, 3))


def _settings(node: Node) -> list[Settings]:
    """Return the parameters to try: some that need less than the whole picture, then those with another one changed.

    The first are the defaults if these do, else one or two changed parameters. Beside a change that reaches too far,
    the change of another parameter keeps it near.
    """
    single = [{param.name: value} for param in node.params if not param.required for value in alternatives(param)]
    pairs = (one | two for one, two in combinations(single, 2) if one.keys() != two.keys())
    first: Settings = next((each for each in ({}, *single, *pairs) if _reach(node, each) is not None), {})
    found = [first]
    for one in single:
        near = [{**first, **two, **one} for two in ({}, *single)]
        reaches = [(-1 if reach is None else reach) for reach in (_reach(node, each) for each in near)]
        if reaches[0] >= 0:
            found.append(near[0])
        elif max(reaches) >= 0:
            found.append(near[reaches.index(max(reaches))])
    return found


def _reach(node: Node, settings: Settings) -> int | None:
    """Return how far from a pixel its region reaches; None if it is the whole picture, or about as large."""
    pixel = Window(0, 0, 1, 1)
    region = _region(node, settings, pixel, Window(-10_000, -10_000, 20_000, 20_000))
    reach = max(-region.x, -region.y, region.x + region.width - 1, region.y + region.height - 1)
    return reach if reach <= _FAR else None


def _region(node: Node, settings: Settings, window: Window, whole: Window) -> Window:
    """Return the window that holds all that the node asks for, inside of the window ``whole``."""
    assert node.region is not None
    asked = node.region(check_params(node, settings), window)
    unknown = asked.keys() - {port.name for port in node.inputs}
    require(not unknown, f"region names {', '.join(sorted(unknown))}, which is no input")
    windows = [asked.get(port.name, whole) for port in node.inputs]
    left, top = (max(min(each[i] for each in windows), whole[i]) for i in (0, 1))
    right, bottom = (min(max(each[i] + each[i + 2] for each in windows), whole[i] + whole[i + 2]) for i in (0, 1))
    require(left < right and top < bottom, f"region of {tuple(window)} has no pixel of the picture {tuple(whole)}")
    return Window(left, top, right - left, bottom - top)


def _kinds(node: Node) -> Iterator[dict[str, PortType]]:
    """Yield one change of an input's type at a time, the first of them none."""
    yield {}
    for port in node.inputs:
        yield from ({port.name: kind} for kind in PORT_TYPES if kind in port.accepts[1:])


def _compare(
    node: Node,
    scene: str,
    kinds: Mapping[str, PortType],
    settings: Settings,
    *,
    mask: bool = False,
    some: slice = slice(None),
) -> None:
    """Compare each output of the whole picture, cut to some windows, with that of the crop to their regions."""
    reach = _reach(node, settings) or 0
    height, width = min(2 * reach, _LARGE) + 18, min(2 * reach, _LARGE) + 21
    inputs = inputs_of(node, scene, height, width)
    inputs |= {name: make_input(kind, scene, height, width) for name, kind in kinds.items()}
    if mask:
        inputs[MASK.name] = make_input("matte", scene, height, width)
    whole = next(iter(inputs.values())).data_window
    try:
        full = run_node(node, inputs, settings)
    except InternalError:
        raise
    except FlowabsError:
        return  # a combination that the node refuses
    for i, window in enumerate(list(_windows(whole))[some]):
        crop = _region(node, settings, window, whole)
        with bands.limited(1 + i % 2):
            outputs = run_node(node, {name: image.on_window(crop) for name, image in inputs.items()}, settings)
        for name, image in outputs.items():
            same = _same_bits(image.on_window(window), full[name].on_window(window))
            place = f"{scene} {width}x{height}, {dict(settings)}: output {name!r} on {tuple(window)}"
            require(same, f"{place} differs if the inputs are cut to {tuple(crop)}")


def _windows(whole: Window) -> Iterator[Window]:
    """Yield windows of a picture: all of it, corners, a pixel, a row, a column, odd ones inside and at the edges."""
    x, y, width, height = whole
    right, bottom = x + width, y + height
    yield whole
    yield Window(x, y, 1, 1)
    yield Window(right - 1, bottom - 1, 1, 1)
    yield Window(x + width // 2, y + height // 2, 1, 1)
    yield Window(x, y + height // 3, width, 1)
    yield Window(x + width // 3, y, 1, height)
    yield Window(x + width // 2 - 3, y + height // 2 - 2, 7, 5)
    yield Window(right - 19, y + 1, 19, 3)
    yield Window(x + 1, bottom - 11, 3, 11)


def _same_bits(one: Image, other: Image) -> bool:
    """Return whether two images have the same type and the same bits; all numbers are float32 or uint32."""
    a, b = one.pixels, other.pixels
    return one.type == other.type and a.shape == b.shape and np.array_equal(a.view(np.uint32), b.view(np.uint32))
