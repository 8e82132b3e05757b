"""Pixels that are not made yet."""

from __future__ import annotations

from typing import NamedTuple

from flowabs_nodes.array_types import Array


class Undecoded(NamedTuple):
    """Code values that pixels are made of once somebody asks for them, and what is done with them on the way."""

    codes: Array  # (H, W, 3)
    space: str
    under: Array | None = None  # what they are the colours of, premultiplied (H, W, 4), if that has alpha
    levels: int = 0  # L* in so many steps, in the space "lab"; 0 is any L*
    softness: float = 0.0
    lines: Array | None = None  # (H, W), laid over
    ink: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)  # red, green, blue, opacity

    @property
    def plain(self) -> bool:
        """Whether these are the code values of the pixels."""
        return self.levels == 0 and self.lines is None
