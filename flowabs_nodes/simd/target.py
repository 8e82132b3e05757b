"""Which vector instructions the kernels use."""

from __future__ import annotations

import os

from flowabs_nodes.errors import CommandError, nearest
from flowabs_nodes.simd.compatible import misfit

try:
    from llvmlite import binding  # type: ignore[import-untyped]
except ImportError as error:  # the command line looks at the path before any node runs
    raise misfit(error) or error from error

ASKED = ("", "auto", "avx512", "portable")  # what FLOWABS_SIMD may be


def kernel_path() -> str:
    """ "avx512" or "portable": what ``FLOWABS_SIMD`` asks for, or else ("" or "auto") what the processor has."""
    _refuse_settings_of_numba()
    asked = os.environ.get("FLOWABS_SIMD", "")
    if asked not in ASKED:
        expected = f"expected {', '.join(ASKED[1:])} or nothing"
        raise CommandError(f"FLOWABS_SIMD: {expected}, found {asked!r}", hint=nearest(asked, ASKED[1:]))
    if asked == "portable":
        return "portable"
    there = {"avx512f", "avx512dq"} <= _features()
    if asked == "avx512" and not there:
        raise CommandError("FLOWABS_SIMD: this processor has no AVX-512 (F and DQ)", hint="auto or portable")
    return "avx512" if there else "portable"


def _refuse_settings_of_numba() -> None:
    """Raise CommandError for a variable by which numba could not be imported, or would compile nothing."""
    threads = os.environ.get("NUMBA_NUM_THREADS", "").strip()
    if threads.lstrip("+-").isdecimal() and int(threads) < 1:
        raise CommandError(f"NUMBA_NUM_THREADS: expected a whole number from 1 up, found {threads!r}")
    interpreted = os.environ.get("NUMBA_DISABLE_JIT", "").strip()
    if interpreted.lstrip("+-").isdecimal() and int(interpreted):
        raise CommandError("NUMBA_DISABLE_JIT: kernels cannot run without being compiled", hint="unset it")


def _features() -> set[str]:
    """Return the processor features that numba compiles for."""
    generic = os.environ.get("NUMBA_CPU_NAME", "").lower() == "generic"
    told = os.environ.get("NUMBA_CPU_FEATURES", "" if generic else None)
    if told is not None:
        return {name[1:] for name in told.split(",") if name.startswith("+")}
    there = {name for name, has in binding.get_host_cpu_features().items() if has}
    return (
        {name for name in there if not name.startswith("avx")} if os.environ.get("NUMBA_ENABLE_AVX") == "0" else there
    )


PATH = kernel_path()
