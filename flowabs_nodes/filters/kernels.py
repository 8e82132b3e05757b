"""How every kernel is compiled: kept on disk, free of the interpreter lock, the same bits on every run.

``contract`` is the only liberty taken with floating point (a multiply and an add become one instruction). Work is split
by rows, and no sum of floats crosses from one thread to another, so the number of threads never changes a bit.
"""

from __future__ import annotations

from numba import njit

kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
parallel_kernel = njit(parallel=True, cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
