"""How every kernel is compiled: kept on disk, free of the interpreter lock, the same bits on every run.

``contract`` is the only liberty taken with floating point (a multiply and an add become one instruction). Work is split
by rows, and no sum of floats crosses from one thread to another, so the number of threads never changes a bit.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from flowabs_nodes.simd.kernel_cache import kept
from flowabs_nodes.simd.kernel_version import PACKAGE

_OPTIONS = {"error_model": "numpy", "fastmath": {"contract"}, "no_cfunc_wrapper": True}

#: Small functions that kernels are made of: always inlined by LLVM. Python cannot call them: making that possible would
#: take longer than all the rest.
inlined = njit(forceinline=True, no_cpython_wrapper=True, **_OPTIONS)

#: Functions that numba itself inlines, before it compiles: for what LLVM must see in the kernel, as scratch memory.
inline = njit(inline="always")


def kernel(function: Callable[..., Any]) -> Any:
    """Return a function of this package as a kernel: compiled when it is first called, or read from disk."""
    # Of functions elsewhere (a test's) the cache would not see a change.
    ours = function.__module__.startswith(f"{PACKAGE}.")
    return kept(function, nogil=True, **_OPTIONS) if ours else njit(nogil=True, **_OPTIONS)(function)


def _keep_freed_memory() -> None:
    """Have the process keep the memory of pictures that are done, for the next ones.

    Linux's C library hands freed memory back beyond twice the largest block freed so far. To get it again, page
    by page, takes a fifth of a small picture's time. Here it learns of a larger block, which nobody has touched.
    """
    np.empty(2**23, np.uint8)


_keep_freed_memory()
