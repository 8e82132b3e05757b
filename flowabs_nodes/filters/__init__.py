"""The paper's filters: pure functions on arrays of code values (0..255 white), no files, no graph.

Each is imported when it is first asked for, so that node declarations can be read without numba. Modules are called
after their function (``filters/etf.py`` holds ``etf``); as an attribute of this package the name always means the
function.
"""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flowabs_nodes.filters.bilateral import bilateral
    from flowabs_nodes.filters.bilateral_oriented import bilateral_oriented
    from flowabs_nodes.filters.blur import blur
    from flowabs_nodes.filters.canny import canny
    from flowabs_nodes.filters.composite import composite
    from flowabs_nodes.filters.dog import dog
    from flowabs_nodes.filters.etf import etf
    from flowabs_nodes.filters.fbl import fbl
    from flowabs_nodes.filters.fdog import fdog
    from flowabs_nodes.filters.fdog_iterative import fdog_iterative
    from flowabs_nodes.filters.flow_blur import flow_blur
    from flowabs_nodes.filters.flow_color import flow_color
    from flowabs_nodes.filters.gradient import measure_reference
    from flowabs_nodes.filters.lic import lic
    from flowabs_nodes.filters.mean_shift import mean_shift, measure_clipping
    from flowabs_nodes.filters.quantize import quantize
    from flowabs_nodes.filters.threshold import threshold
    from flowabs_nodes.filters.xdog import xdog, xdog_rho

__all__ = [
    "bilateral",
    "bilateral_oriented",
    "blur",
    "canny",
    "composite",
    "dog",
    "etf",
    "fbl",
    "fdog",
    "fdog_iterative",
    "flow_blur",
    "flow_color",
    "lic",
    "mean_shift",
    "measure_clipping",
    "measure_reference",
    "quantize",
    "threshold",
    "xdog",
    "xdog_rho",
]

_MODULES = {name: name for name in __all__} | {
    "measure_clipping": "mean_shift",
    "measure_reference": "gradient",
    "xdog_rho": "xdog",
}


class _Filters(ModuleType):
    """Importing a submodule binds it to its package; here that binds the function of the same name instead."""

    def __setattr__(self, name: str, value: Any) -> None:
        if isinstance(value, ModuleType) and name in __all__:
            value = getattr(value, name)
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Filters


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_MODULES[name]}")
    function = getattr(module, name)
    globals()[name] = function
    return function


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
