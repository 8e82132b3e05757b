"""The paper's filters: pure functions on arrays of code values (diffuse white is 255), no files, no graph.

Each function is imported when it is first asked for, so that node declarations can be read without numba.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from flowabs_nodes.forks import IMPORTING
from flowabs_nodes.simd.compatible import misfit

if TYPE_CHECKING:
    from flowabs_nodes.filters.compositing import composite
    from flowabs_nodes.filters.flow.etf import etf
    from flowabs_nodes.filters.flow.flow_blur import flow_blur
    from flowabs_nodes.filters.flow.flow_color import flow_color
    from flowabs_nodes.filters.flow.gradient import measure_reference
    from flowabs_nodes.filters.flow.lic import lic
    from flowabs_nodes.filters.gaussian_blur import blur
    from flowabs_nodes.filters.highlights import shoulder
    from flowabs_nodes.filters.inks import ink_color
    from flowabs_nodes.filters.lines.canny import canny
    from flowabs_nodes.filters.lines.dog import dog
    from flowabs_nodes.filters.lines.fdog import fdog
    from flowabs_nodes.filters.lines.fdog_iterative import fdog_iterative
    from flowabs_nodes.filters.lines.stroke import stroke
    from flowabs_nodes.filters.lines.threshold import threshold
    from flowabs_nodes.filters.lines.xdog import xdog, xdog_rho
    from flowabs_nodes.filters.motion.boil import boil
    from flowabs_nodes.filters.motion.optical_flow import optical_flow
    from flowabs_nodes.filters.motion.window import motion_window
    from flowabs_nodes.filters.passes.aov_lines import aov_lines
    from flowabs_nodes.filters.passes.id_matte import id_matte
    from flowabs_nodes.filters.passes.ink_lines import ink_lines
    from flowabs_nodes.filters.passes.join_lines import join_lines
    from flowabs_nodes.filters.regions.bilateral import bilateral
    from flowabs_nodes.filters.regions.bilateral_oriented import bilateral_oriented
    from flowabs_nodes.filters.regions.fbl import fbl
    from flowabs_nodes.filters.regions.mean_shift import mean_shift, measure_clipping
    from flowabs_nodes.filters.regions.quantize import quantize
    from flowabs_nodes.filters.regions.rolling_guidance import rolling_guidance
    from flowabs_nodes.filters.warming import warm_up

__all__ = [
    "aov_lines",
    "bilateral",
    "bilateral_oriented",
    "blur",
    "boil",
    "canny",
    "composite",
    "dog",
    "etf",
    "fbl",
    "fdog",
    "fdog_iterative",
    "flow_blur",
    "flow_color",
    "id_matte",
    "ink_color",
    "ink_lines",
    "join_lines",
    "lic",
    "mean_shift",
    "measure_clipping",
    "measure_reference",
    "motion_window",
    "optical_flow",
    "quantize",
    "rolling_guidance",
    "shoulder",
    "stroke",
    "threshold",
    "warm_up",
    "xdog",
    "xdog_rho",
]

#: The module of this package that holds each function.
_HOMES = {
    "aov_lines": "passes.aov_lines",
    "bilateral": "regions.bilateral",
    "bilateral_oriented": "regions.bilateral_oriented",
    "blur": "gaussian_blur",
    "boil": "motion.boil",
    "canny": "lines.canny",
    "composite": "compositing",
    "dog": "lines.dog",
    "etf": "flow.etf",
    "fbl": "regions.fbl",
    "fdog": "lines.fdog",
    "fdog_iterative": "lines.fdog_iterative",
    "flow_blur": "flow.flow_blur",
    "flow_color": "flow.flow_color",
    "id_matte": "passes.id_matte",
    "ink_color": "inks",
    "ink_lines": "passes.ink_lines",
    "join_lines": "passes.join_lines",
    "lic": "flow.lic",
    "mean_shift": "regions.mean_shift",
    "measure_clipping": "regions.mean_shift",
    "measure_reference": "flow.gradient",
    "motion_window": "motion.window",
    "optical_flow": "motion.optical_flow",
    "quantize": "regions.quantize",
    "rolling_guidance": "regions.rolling_guidance",
    "shoulder": "highlights",
    "stroke": "lines.stroke",
    "threshold": "lines.threshold",
    "warm_up": "warming",
    "xdog": "lines.xdog",
    "xdog_rho": "lines.xdog",
}


if not TYPE_CHECKING:  # a type checker would take any name for Any

    def __getattr__(name: str) -> Any:
        if name not in _HOMES:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        try:
            with IMPORTING:
                module = importlib.import_module(f"{__name__}.{_HOMES[name]}")
        except (ImportError, AttributeError, TypeError) as error:
            wrong_numba = misfit(error)
            if wrong_numba is None:
                raise
            raise wrong_numba from error
        function = getattr(module, name)
        globals()[name] = function
        return function


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
