"""flowabs: line drawings and flattened colour from scene-linear EXR plates, by filters that follow the picture's flow.

::

    import flowabs_nodes as fa

    drawn = fa.abstraction(rgb, line_width=1.5)  # one call: an array in, an array of the same kind out

    graph = fa.load_graph("abstraction")  # a path, a shipped name, or a dict
    out = graph.run(given={"plate": fa.Image.from_array(rgb)}, outputs=["comp"])
    report = fa.run("abstraction", input="shot.####.exr", output="out.####.exr", frames="1001-1100")

Importing this package is quick: every name below is loaded the first time it is used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from flowabs_nodes.forks import IMPORTING

if TYPE_CHECKING:
    from flowabs_nodes import color, filters
    from flowabs_nodes.engine.render_sequence import run
    from flowabs_nodes.engine.report import Report
    from flowabs_nodes.engine.runnable import RunnableGraph, load_graph
    from flowabs_nodes.engine.session import Session
    from flowabs_nodes.errors import Cancelled, FlowabsError
    from flowabs_nodes.image import Image
    from flowabs_nodes.one_call import abstraction, abstraction_hdr, bold, flat, inked, lines, pencil, portrait

__version__ = "0.3.0"

_HOMES = {
    "FlowabsError": "errors",
    "Image": "image",
    "Cancelled": "errors",
    "Report": "engine.report",
    "RunnableGraph": "engine.runnable",
    "Session": "engine.session",
    **dict.fromkeys(
        ("abstraction", "abstraction_hdr", "bold", "flat", "inked", "lines", "pencil", "portrait"), "one_call"
    ),
    "load_graph": "engine.runnable",
    "run": "engine.render_sequence",
}
_MODULES = ("color", "filters")

__all__ = [
    "Cancelled",
    "FlowabsError",
    "Image",
    "Report",
    "RunnableGraph",
    "Session",
    "__version__",
    "abstraction",
    "abstraction_hdr",
    "bold",
    "color",
    "filters",
    "flat",
    "inked",
    "lines",
    "load_graph",
    "pencil",
    "portrait",
    "run",
]


if not TYPE_CHECKING:  # a type checker would take any name for Any

    def __getattr__(name: str) -> Any:
        if name in _HOMES:
            with IMPORTING:
                value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
            globals()[name] = value
            return value
        if name in _MODULES:
            with IMPORTING:
                return importlib.import_module(f"{__name__}.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
