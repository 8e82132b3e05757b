"""Peers to time in the same run: OpenCV's filters where it is installed, and references for the machine's own speed.

``cv2.bilateralFilter`` does the work of stage ``bilateral-full``: the same float code values and sigmas, over a disc
where ours is a square. The other two of OpenCV take 8 bits and its own defaults.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

from flowabs_nodes import filters
from tools.bench.cases import Plate
from tools.bench.timing import Case


def _numpy(plate: Plate) -> Case:
    import numpy as np

    source, result = plate.code / -255, np.empty_like(plate.code)  # no memory is asked for: its price varies
    return Case(lambda _: np.exp(source, out=result))


def _dog(plate: Plate) -> Case:
    return Case(lambda _: filters.dog(plate.code))


def _bilateral(plate: Plate) -> Case:
    cv2 = _opencv()
    return Case(lambda _: cv2.bilateralFilter(plate.codes, 13, 10, 2))


def _stylization(plate: Plate) -> Case:
    cv2 = _opencv()
    return Case(lambda _: cv2.stylization(plate.bytes))


def _edge_preserving(plate: Plate) -> Case:
    cv2 = _opencv()
    return Case(lambda _: cv2.edgePreservingFilter(plate.bytes))


def _opencv() -> Any:
    from flowabs_nodes.filters.opencv import opencv

    return opencv("this comparison")


PEERS: dict[str, Callable[[Plate], Case]] = {
    "dog": _dog,
    "numpy.exp": _numpy,
    "cv2.bilateralFilter": _bilateral,
    "cv2.stylization": _stylization,
    "cv2.edgePreservingFilter": _edge_preserving,
}


def available() -> tuple[str, ...]:
    """Return the names of the peers that can run here."""
    return tuple(name for name in PEERS if not name.startswith("cv2.") or find_spec("cv2") is not None)
