"""Makes the ``region`` of a node from its halo: the pixels around a pixel that decide about the result there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from flowabs_nodes.image import Window

Params = Mapping[str, Any]

#: Returns the windows of a node's inputs that a window of its outputs is made from (:class:`~.declare.Node`).
Region = Callable[[Params, Window], Mapping[str, Window]]


def pixelwise(*inputs: str) -> Region:
    """Return the region of a node that computes each pixel from the same pixel of its ``inputs``."""
    return within(_no_halo, *inputs)


def within(halo: Callable[[Params], int | None], *inputs: str) -> Region:
    """Return the region of a node that reads ``halo(params)`` pixels to every side, the same on all its ``inputs``.

    A halo of None stands for the whole picture: with these parameters some number comes of all pixels.
    """
    return partial(_within, halo, inputs)


def _no_halo(params: Params) -> int:
    return 0


def _within(
    halo: Callable[[Params], int | None], inputs: tuple[str, ...], params: Params, window: Window
) -> dict[str, Window]:
    """Return the window and its halo for each input; nothing where the halo is the whole picture."""
    pixels = halo(params)
    if pixels is None:
        return {}
    around = Window(window.x - pixels, window.y - pixels, window.width + 2 * pixels, window.height + 2 * pixels)
    return dict.fromkeys(inputs, around)
