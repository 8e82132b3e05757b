"""Functions that numba itself inlines, before it compiles: for what LLVM must see in the kernel, as scratch memory."""

from numba import njit

inline = njit(inline="always")
