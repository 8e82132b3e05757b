"""Which vector instructions the kernels use."""

from __future__ import annotations

import os

from llvmlite import binding  # type: ignore[import-untyped]


def _path() -> str:
    """ "avx512", or "portable" where the processor has none or ``FLOWABS_SIMD`` is "portable"."""
    if os.environ.get("FLOWABS_SIMD", "") == "portable":
        return "portable"
    given = os.environ.get("NUMBA_CPU_FEATURES")
    if given is not None:  # what numba compiles for, if told to
        features = {name[1:] for name in given.split(",") if name.startswith("+")}
    else:
        features = {name for name, there in binding.get_host_cpu_features().items() if there}
    return "avx512" if {"avx512f", "avx512dq"} <= features else "portable"


PATH = _path()
