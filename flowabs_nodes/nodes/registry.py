"""Collects the catalogue: the nodes that come with the package, and those that other packages add by entry point.

A node comes with the package if a module of this folder holds its :class:`Node`: a new file is all that a new node
needs. Another package adds nodes with an entry point of the group ``flowabs.nodes`` that names a :class:`Node` or
several. One that cannot be loaded, is declared wrongly, or takes a name that is taken, is left out and reported, and
stops nothing.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterable
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType

from flowabs_nodes.errors import ArgumentError, nearest
from flowabs_nodes.image import PORT_TYPES
from flowabs_nodes.nodes.declare import Node
from flowabs_nodes.signals import asks_to_stop

GROUP = "flowabs.nodes"

#: The order in which people read about the nodes of the package. A node that is not named here follows by its file.
READING_ORDER = (
    *("read", "read_aov", "read_depth", "read_normal", "read_motion", "read_id", "write"),
    *("matte", "id_matte", "exposure", "shoulder"),
    *("etf", "lic", "flow_color", "flow_blur"),
    *("dog", "fdog", "fdog_iterative", "stroke", "canny"),
    *("aov_lines", "ink_lines", "join_lines", "boil"),
    *("fbl", "rolling_guidance", "bilateral", "bilateral_oriented", "mean_shift", "quantize"),
    *("optical_flow", "motion_window"),
    *("composite", "merge", "switch", "blur", "grade", "invert", "colorspace"),
    *("shuffle", "constant", "crop", "reformat"),
)


def catalogue() -> dict[str, Node]:
    """Return every installed node by type: first those of the package, in reading order, then the others by package."""
    return dict(_load()[0])


def load_problems() -> dict[str, str]:
    """Return why nodes of other packages are not in the catalogue, by "package: entry point"."""
    return dict(_load()[1])


@cache
def builtin() -> tuple[Node, ...]:
    """Return every node that a module of this folder holds, each once, in reading order."""
    found: dict[str, Node] = {}
    for module in pkgutil.iter_modules(importlib.import_module(__package__).__path__):  # in a zip and frozen too
        for value in vars(importlib.import_module(f"{__package__}.{module.name}")).values():
            if isinstance(value, Node) and found.setdefault(value.type, value) is not value:
                raise ArgumentError(f"node {value.type!r} is declared a second time, in {__package__}.{module.name}")
    place = {type: i for i, type in enumerate(READING_ORDER)}
    return tuple(sorted(found.values(), key=lambda node: place.get(node.type, len(place))))


@cache
def _load() -> tuple[MappingProxyType[str, Node], MappingProxyType[str, str]]:
    nodes = {node.type: node for node in builtin()}
    owners = dict.fromkeys(nodes, "flowabs-nodes")
    problems: dict[str, str] = {}
    points = entry_points(group=GROUP)
    for point in sorted(points, key=lambda point: (_package(point), point.name)):
        where = f"{_package(point)}: {point.name}"
        try:
            added = _load_nodes(point)
        except BaseException as error:  # another package may fail in any way when it is imported, by sys.exit too
            if isinstance(error, KeyboardInterrupt) and asks_to_stop(error):
                raise
            problems[where] = f"{type(error).__name__}: {error}"
            continue
        wrong = [fault for node in added for fault in faults(node)]
        wrong += [f"{node.type!r} is already a node of {owners[node.type]}" for node in added if node.type in owners]
        if wrong:
            problems[where] = "; ".join(wrong)
        else:
            nodes.update({node.type: node for node in added})
            owners.update({node.type: _package(point) for node in added})
    return MappingProxyType(nodes), MappingProxyType(problems)


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else point.module.partition(".")[0]


def _load_nodes(point: EntryPoint) -> tuple[Node, ...]:
    loaded = point.load()
    nodes = (loaded,) if isinstance(loaded, Node) else tuple(loaded) if isinstance(loaded, Iterable) else (loaded,)
    for node in nodes:
        if not isinstance(node, Node):
            raise TypeError(f"{point.value} is {type(node).__name__}, not a Node or several")
    if len({node.type for node in nodes}) < len(nodes):
        raise ValueError(f"{point.value} has two nodes of one type")
    return nodes


def faults(node: Node) -> list[str]:
    """Return what is wrong with a declaration: port types that do not exist, defaults outside their own range."""
    found = []
    for port in (*node.inputs, *filter(None, [node.extra_inputs])):
        found += [
            f"{node.type}: input {port.name!r} of type {kind!r}; {nearest(kind, PORT_TYPES)}"
            for kind in port.accepts or (port.types,)
            if kind not in PORT_TYPES
        ]
    for port in node.outputs:
        unknown = [name for name in port.follows if name not in node.all_inputs]
        if unknown:
            found.append(f"{node.type}: output {port.name!r} is of the type of {unknown[0]!r}, which is no input")
        elif port.same_as is None and port.types not in PORT_TYPES:
            found.append(f"{node.type}: output {port.name!r} of type {port.types!r}; {nearest(port.types, PORT_TYPES)}")
    for param in node.params:
        wrong = None if param.required else param.problem(param.default)
        if wrong:
            found.append(f"{node.type}: default of {param.name!r}, {param.default!r}, is not {wrong[1]}")
    return found
