"""Runs graphs: plans what to compute, names results by keys, calls nodes, renders frames and sequences."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.engine.render_sequence import run
    from flowabs_nodes.engine.report import FrameReport, Note, Report
    from flowabs_nodes.engine.runnable import RunnableGraph, load_graph

_HOMES = {
    "FrameReport": "report",
    "Note": "report",
    "Report": "report",
    "RunOptions": "options",
    "RunnableGraph": "runnable",
    "load_graph": "runnable",
    "run": "render_sequence",
}

__all__ = ["FrameReport", "Note", "Report", "RunOptions", "RunnableGraph", "load_graph", "run"]


if not TYPE_CHECKING:  # a type checker would take any name for Any

    def __getattr__(name: str) -> Any:
        if name in _HOMES:
            value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
            globals()[name] = value
            return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
