"""Decode and encode the pixels of a file that describes its own colours: a transfer function and primaries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flowabs_nodes.array_types import Array, Float64
from flowabs_nodes.color.spaces import ColorSpace


class Transfer(Protocol):
    """A transfer function: from the codes of a file, 0..1, to linear light, and back. Arrays keep their shape."""

    def linear(self, codes: Float64) -> Float64:
        """Return linear light."""
        ...

    def codes(self, linear: Float64) -> Float64:
        """Return codes: the inverse of :meth:`linear`."""
        ...


@dataclass(frozen=True)
class Encoding:
    """How the codes of a file stand for colours, where no OCIO name says it.

    Attributes
    ----------
    name
        For the log: "ICC profile 'Adobe RGB (1998)'".
    space
        The scene-linear space that codes are decoded to.
    transfers
        The transfer functions of red, green and blue.
    profile
        The bytes of the ICC profile of RGB pixels that says all this; empty where there is none.
    cicp
        The code points of ITU-T H.273 that say all this; empty where there are none.
    """

    name: str
    space: ColorSpace
    transfers: tuple[Transfer, Transfer, Transfer]
    profile: bytes = b""
    cicp: tuple[int, ...] = ()

    def __str__(self) -> str:
        return self.name

    def linear(self, rgb: Array) -> Array:
        """Return the scene-linear colours, (H, W, 3) float32 in ``space``, of codes of the same shape."""
        planes = [transfer.linear(rgb[..., i].astype(np.float64)) for i, transfer in enumerate(self.transfers)]
        return np.stack(planes, axis=-1).astype(np.float32)

    def encoded(self, rgb: Array) -> Array:
        """Return the codes, (H, W, 3) float32, of scene-linear colours of ``space``: the inverse of :meth:`linear`."""
        planes = [transfer.codes(rgb[..., i].astype(np.float64)) for i, transfer in enumerate(self.transfers)]
        return np.stack(planes, axis=-1).astype(np.float32)

    def like(self, transfer: Transfer, tolerance: float) -> bool:
        """Return whether every channel's transfer function is this one, within ``tolerance`` of linear light."""
        ramp = np.linspace(0, 1, 256)
        wanted = transfer.linear(ramp)
        return all(np.allclose(each.linear(ramp), wanted, rtol=0, atol=tolerance) for each in self.transfers)
