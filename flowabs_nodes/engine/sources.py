"""Finds the file that each read node takes on a frame, by the policy for missing frames where it is not there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from flowabs_nodes.engine.error_boundary import error_boundary
from flowabs_nodes.engine.plan import Step, Unit, file_role
from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.hashing import content_hash
from flowabs_nodes.io.sequences import Sequence, Source
from flowabs_nodes.io.settings import checked

if TYPE_CHECKING:
    from flowabs_nodes.engine.options import RunOptions
    from flowabs_nodes.graph.model import Graph


def find_sources(
    graph: Graph,
    steps: Iterable[Step],
    params: Mapping[Unit, Mapping[str, Any]],
    options: RunOptions,
) -> dict[Unit, Source]:
    """Find the source of every step that reads; ``options.missing`` goes before the node's own policy.

    Raises
    ------
    CommandError
        file-not-set, or outside-root.
    ReadError
        missing-file, with node and frame, where the policy does not help.
    """
    found = {}
    for unit in (step.unit for step in steps if file_role(graph, step.unit.node) == "input"):
        with error_boundary(unit.node, unit.frame):
            values = params[unit]
            source = Sequence(file_of(graph, unit.node, values)).resolve(
                unit.frame, options.missing or values.get("missing", "error")
            )
            if source.path is not None:
                checked(source.path, options.settings)
            found[unit] = source
    return found


def file_of(graph: Graph, node: str, values: Mapping[str, Any]) -> str:
    """Return the file or pattern that a read or write node is set to.

    Raises
    ------
    CommandError
        file-not-set, with the flag that sets it.
    """
    param = graph.nodes[node].declaration.file_param
    assert param is not None
    if not values.get(param.name):
        what, flag = ("reads", "-i") if param.role == "input" else ("writes", "-o")
        raise CommandError(
            f"node {node!r} {what} a file, but none is set",
            code="file-not-set",
            hint=f"{flag} FILE, or --set {node}.{param.name}=FILE",
            node=node,
            parameter=param.name,
        )
    return str(values[param.name])


def source_contents(sources: Mapping[Unit, Source]) -> dict[Unit, str]:
    """Return what stands in each source, for its key.

    That is the hash of the file's content; before it "black " where the file only lends its windows to a black frame.

    Raises
    ------
    ReadError
        A file cannot be read; with node and frame.
    """
    found = {}
    for unit, source in sources.items():
        with error_boundary(unit.node, unit.frame):
            assert source.path is not None
            found[unit] = ("black " if source.black else "") + content_hash(source.path)
    return found
