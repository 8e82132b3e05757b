"""Finds the order in which nodes can run, and the cycles that leave none (Tarjan 1972, without recursion)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence


def components(needs: Mapping[str, Sequence[str]]) -> Iterator[list[str]]:
    """Yield the strongly connected components of a graph, each after those it needs.

    ``needs`` has, for every node, the nodes it takes its inputs from. A component of one is a node by itself (it may
    still need itself); in any larger one, each node needs all others.
    """
    found: dict[str, int] = {}
    lowest: dict[str, int] = {}
    pending: list[str] = []
    placed: set[str] = set()
    for root in needs:
        if root in found:
            continue
        found[root] = lowest[root] = len(found)
        pending.append(root)
        path = [(root, iter(needs[root]))]
        while path:
            node, rest = path[-1]
            for source in rest:
                if source not in found:
                    found[source] = lowest[source] = len(found)
                    pending.append(source)
                    path.append((source, iter(needs[source])))
                    break
                if source not in placed:
                    lowest[node] = min(lowest[node], found[source])
            else:
                path.pop()
                if path:
                    above = path[-1][0]
                    lowest[above] = min(lowest[above], lowest[node])
                if lowest[node] == found[node]:
                    start = len(pending) - 1
                    while pending[start] != node:
                        start -= 1
                    component = pending[start:]
                    del pending[start:]
                    placed.update(component)
                    yield component


def cycle(component: Sequence[str], needs: Mapping[str, Sequence[str]]) -> list[str]:
    """Return one cycle within a component, in the direction images travel, its first node repeated; [] if none."""
    inside = set(component)
    node, path = component[0], [component[0]]
    seen = {node: 0}
    while True:
        source = next((source for source in needs[node] if source in inside), None)
        if source is None:
            return []
        path.append(source)
        if source in seen:
            return path[seen[source] :][::-1]
        seen[source] = len(path) - 1
        node = source
