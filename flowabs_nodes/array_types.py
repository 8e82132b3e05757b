"""Names of the array types in signatures. Docstrings give the shapes: (H, W, C), rows from top to bottom.

In kernels they also stand for scratch memory (:func:`~flowabs_nodes.simd.memory.scratch`) of the same numbers.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

#: Pictures, flows and masks of pixels.
Array = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
#: Ids.
Uint32 = npt.NDArray[np.uint32]
#: A flow in kernels: t.x + i t.y for each pixel.
Complex64 = npt.NDArray[np.complex64]


class HasArray(Protocol):
    """A picture that NumPy can read: an array, or another library's, such as a tensor or a Pillow image."""

    def __array__(self) -> npt.NDArray[Any]:
        """Return the picture as an array."""
