"""Make the filters ready ahead of their first use: imported, and their kernels compiled, or read from disk."""

from __future__ import annotations

import inspect
from typing import Any

import numpy as np

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError, FlowabsError, nearest

_HEIGHT, _WIDTH = 24, 40
_ONES = dict.fromkeys((-1, 0, 1), np.ones((_HEIGHT, _WIDTH), np.float32))
#: Parameters whose default leaves out a kernel that graphs of today use.
_SWITCHED_ON: dict[str, Any] = {
    "guides": _ONES,
    "depths": _ONES,
    "soft_lines": 1.0,
    "evidence": 1.0,
    "thin_lines": 4.5,
    "lone_lines": 6.0,
    "working_scale": "1/2",
    "by_gradient": 1.0,
    "min_length": 4.0,
    "amount": 1.0,
}
#: Optional pictures that are given too: what shipped graphs give, and without which a filter has nothing to do.
_ALSO_GIVEN = ("edge_strength", "edge_flow", "depth", "normal", "id", "coverage", "material")


def warm_up(*names: str) -> None:
    """Run filters once on a small picture, with default parameters, so that their first use takes no longer.

    What the options of the graphs that come with the package need is made ready too, though they are off by default:
    soft outlines, thin and lone lines, evidence, a working scale, steps by the gradient, a stroke's length, a window's
    guide and depth, edges from passes, boil.

    A program calls it before it starts threads, and before it forks: children share what is loaded, and none of them
    compiles. What is compiled stays on disk. Kernels of other parameters than the defaults (``kernel="separable"``, an
    alpha) are made ready when they are first asked for.

    Parameters
    ----------
    names
        Filters of this package; none: all of them, but for those whose package, OpenCV, is not installed.

    Raises
    ------
    ArgumentError
        There is no filter of this name.
    FlowabsError
        A filter that was named cannot run.
    """
    known = [name for name in filters.__all__ if name != "warm_up"]
    for name in names:
        if name not in known:
            raise ArgumentError(f"there is no filter {name!r}", hint=nearest(name, known), parameter="names")
    pictures = _pictures()
    for name in names or known:
        function = getattr(filters, name)
        given = inspect.signature(function).parameters.values()
        needed = {each.name: pictures[each.name] for each in given if each.default is each.empty}
        needed |= {each.name: pictures[each.name] for each in given if each.name in _ALSO_GIVEN}
        needed |= {each.name: _SWITCHED_ON[each.name] for each in given if each.name in _SWITCHED_ON}
        try:
            function(**needed)
        except FlowabsError as error:
            if names or error.code != "missing-package":
                raise


def _pictures() -> dict[str, Any]:
    """Return what a filter takes, by the name of its parameter: noise of 24 x 40 pixels, on three frames or on one."""
    chance = np.random.default_rng(1)
    white = np.float32(255)
    mono = white * chance.random((_HEIGHT, _WIDTH), np.float32)
    color = white * chance.random((_HEIGHT, _WIDTH, 3), np.float32)
    angle = np.float32(2 * np.pi) * chance.random((_HEIGHT, _WIDTH), np.float32)
    return {
        **dict.fromkeys(("code", "response", "lightness"), mono),
        "lstar": mono / np.float32(2.55),
        **dict.fromkeys(("lines", "under", "edge_strength"), mono / white),
        "codes": color,
        **dict.fromkeys(("rgb", "image"), color / white),
        **dict.fromkeys(("flow", "edge_flow"), np.stack([np.cos(angle), np.sin(angle)], axis=2).astype(np.float32)),
        "images": dict.fromkeys((-1, 0, 1), color),
        "motions": dict.fromkeys((-1, 0, 1), np.zeros((_HEIGHT, _WIDTH, 4), np.float32)),
        "gradient_reference": "max",
        "depth": 1 + mono / white,
        "normal": color / white,
        **dict.fromkeys(("id", "ids", "material"), (mono // 32).astype(np.uint32)),
        "coverage": mono / white,
        "p": 20.0,
        "chosen": [1, 2],
        "distance": mono / 25 - 2,
        "mattes": {"outline": mono / white},
    }
