"""Finds the nodes of a graph whose function imports a package that is not installed."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from flowabs_nodes.graph.model import Graph, GraphNode
from flowabs_nodes.graph.problems import GraphError, Problem, pointer


def missing_packages(nodes: Iterable[GraphNode]) -> list[Problem]:
    """Return a problem for each module that a node needs and that is not installed; the hint installs it."""
    return [
        Problem(
            "missing-package",
            pointer(("nodes", node.name)),
            f"no module {module}",
            f"{module}, which {node.declaration.name} needs",
            f"pip install '{source}'",
        )
        for node in nodes
        for module, source in node.declaration.missing().items()
    ]


def refuse_missing_packages(graph: Graph, names: Collection[str]) -> None:
    """Raise GraphError where one of the nodes of these names cannot run for want of a package."""
    problems = missing_packages(node for name, node in graph.nodes.items() if name in names)
    if problems:
        raise GraphError(problems, file=graph.source or None)
