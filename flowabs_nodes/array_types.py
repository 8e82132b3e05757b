"""Names of the array types in signatures. Docstrings give the shapes: (H, W, C), rows from top to bottom.

In kernels they also stand for scratch memory (:func:`~flowabs_nodes.simd.memory.scratch`) of the same numbers.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

#: Pictures, flows and masks of pixels.
Array = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]
#: A flow in kernels: t.x + i t.y for each pixel.
Complex64 = npt.NDArray[np.complex64]
