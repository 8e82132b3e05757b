"""Imports the compiler of kernels in one thread alone, for runs that begin in several threads at once.

numba's modules import each other in circles. Where two threads import different ones of them for the first time, one
of the two finds half a module, or Python sees a deadlock.
"""

from __future__ import annotations

import importlib
import threading

_loading = threading.Lock()


def load_compiler() -> None:
    """Import numba and what kernels are written in; whoever comes meanwhile waits."""
    with _loading:
        importlib.import_module("flowabs_nodes.simd.lanes")
