"""Brings older documents up to date: first the format as a whole, then each node to the version that is installed.

A format upgrade is a function from a document of version n to one of version n + 1, in :data:`FORMAT_UPGRADES` under
n. A node's are in its declaration (:attr:`Node.upgrades`), from the parameters of version n, as the graph writes them
(knobs and curves included), to those of version n + 1.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from flowabs_nodes.graph.format import FORMAT_NAME, FORMAT_VERSION
from flowabs_nodes.graph.problems import Place, Problems, show
from flowabs_nodes.nodes.declare import Node

Upgrade = Callable[[dict[str, Any]], dict[str, Any]]

FORMAT_UPGRADES: Mapping[int, Upgrade] = {}  # version 1 is the first

_FORMAT = re.compile(rf"{re.escape(FORMAT_NAME)}/([1-9][0-9]{{0,5}})")
_TYPE = re.compile(r"([a-z][a-z0-9_]*)@([1-9][0-9]{0,5})")


def upgrade_format(
    document: dict[str, Any],
    problems: Problems,
    notes: list[str],
    *,
    newest: int = FORMAT_VERSION,
    upgrades: Mapping[int, Upgrade] = FORMAT_UPGRADES,
) -> dict[str, Any] | None:
    """Return the document in the newest format; None if its format is newer still, and so cannot be read at all."""
    written = document.get("format")
    expected = f'"{FORMAT_NAME}/{newest}"'
    match = _FORMAT.fullmatch(written) if isinstance(written, str) else None
    if match is None:
        found = "nothing" if "format" not in document else show(written)
        problems.add("bad-value", ("format",), found, expected)
        return {**document, "format": f"{FORMAT_NAME}/{newest}"}
    version = int(match[1])
    if version > newest:
        problems.add("newer-version", ("format",), show(written), f"{expected} or older", "update flowabs-nodes")
        return None
    for step in range(version, newest):
        document = upgrades[step](document)
    if version < newest:
        notes.append(f"format {version} read as {newest}")
    return document


def upgrade_node(
    node: dict[str, Any], place: Place, catalogue: Mapping[str, Node], problems: Problems, notes: list[str]
) -> Node | None:
    """Return the declaration that a node's ``type`` names, or None. An older node is brought up to it, in place."""
    written = node["type"]
    match = _TYPE.fullmatch(written)
    declaration = catalogue.get(match[1]) if match else None
    here = (*place, "type")
    if match is None or declaration is None:
        name = written.partition("@")[0]
        close = name if name in catalogue else problems.closest(name, catalogue)
        hint = f"did you mean {catalogue[close].name!r}?" if close else "`flowabs nodes` lists them all"
        problems.add("unknown-type", here, show(written), "type@version of an installed node", hint)
        return None
    version = int(match[2])
    if version > declaration.version:
        expected = f"{declaration.name!r} or older"
        problems.add("newer-version", here, show(written), expected, "update the package that has this node")
        return None
    params = node.get("params", {})
    for step in range(version, declaration.version):
        upgrade = declaration.upgrades.get(step)
        if upgrade is None:
            problems.add(
                "unknown-type", here, show(written), f"{declaration.name!r}", f"version {step} is not readable"
            )
            return None
        try:
            params = dict(upgrade(dict(params)))
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            found = f"{type(error).__name__}: {error}"
            problems.add("bad-value", (*place, "params"), found, f"parameters of {declaration.type}@{step}")
            return None
    if version < declaration.version:
        node.update(type=declaration.name, params=params)
        notes.append(f"{place[-1]}: {written} read as {declaration.name}")
    return declaration
