"""Makes small graphs for the tests."""

from typing import Any


def small(**nodes: Any) -> dict[str, Any]:
    """Return plate -> flow -> lines -> out, with other bodies of nodes, or more of them."""
    return {
        "format": "flowabs.graph/1",
        "name": "small",
        "nodes": {
            "plate": {"type": "read@1"},
            "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
            "lines": {"type": "fdog@1", "inputs": {"image": "plate", "flow": "flow"}},
            "out": {"type": "write@1", "inputs": {"image": "lines"}},
            **nodes,
        },
    }


def with_params(type_name: str, **params: Any) -> dict[str, Any]:
    """Return a graph with a node "x" that sets these parameters."""
    return small(x={"type": type_name, "inputs": {"image": "plate"}, "params": params})


def with_knobs(*, drives: dict[str, Any] | None = None, **knobs: Any) -> dict[str, Any]:
    """Return a graph with these knobs, which drive parameters of "lines" as ``drives`` says."""
    graph = small(lines={"type": "fdog@1", "inputs": {"image": "plate", "flow": "flow"}, "params": drives or {}})
    return {**{key: graph[key] for key in ("format", "name")}, "interface": knobs, "nodes": graph["nodes"]}


WIDTH = {"type": "float", "default": 1.5, "min": 0.3, "max": 4, "unit": "px", "group": "Lines", "help": "Width."}
