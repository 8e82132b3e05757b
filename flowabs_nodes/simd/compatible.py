"""Which numba the vector layer is made for, and what to say where another one does not fit.

This module imports no numba.
"""

from __future__ import annotations

import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from flowabs_nodes.errors import FlowabsError

NUMBA = ">=0.60,<0.69"  #: As pyproject.toml has it: the oldest and the newest that pass the tests.

#: Whose functions run while kernels are compiled, and never later.
_BUILDERS = {"lanes.py", "memory.py", "avx512.py"}
#: colour-science 0.4.7 runs without SciPy by this.
_STAND_IN = "a package, such as colour-science, put a stand-in for SciPy into sys.modules: pip install scipy"


class NumbaError(FlowabsError):
    """The installed numba is not one that kernels can be built with."""

    code = "numba-misfit"


def misfit(error: BaseException) -> NumbaError | None:
    """Return what to raise in place of an error if it came up while this package was building its vector layer."""
    if not isinstance(error, ImportError | AttributeError | TypeError):
        return None
    place = error.__traceback__
    while place is not None:
        code = place.tb_frame.f_code
        file = Path(code.co_filename)
        if file.parent == Path(__file__).parent and (code.co_name == "<module>" or file.name in _BUILDERS):
            there = " and ".join(f"{name} {_version(name)}" for name in ("numba", "llvmlite"))
            hint = _STAND_IN if _scipy_is_a_stand_in() else f"works with numba{NUMBA}"
            return NumbaError(f"kernels cannot be built with {there} ({error})", hint=hint)
        place = place.tb_next
    return None


def _scipy_is_a_stand_in() -> bool:
    """Return whether SciPy counts as imported and comes from no file: numba asks it for its version, and fails."""
    scipy = sys.modules.get("scipy")
    return scipy is not None and not getattr(scipy, "__file__", None)


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "missing"
