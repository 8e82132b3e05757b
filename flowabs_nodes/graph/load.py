"""Loads and checks graphs, from a file, a shipped name, JSON text or a dict."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flowabs_nodes.errors import ArgumentError, CommandError, ReadError
from flowabs_nodes.graph.jsonable import jsonable
from flowabs_nodes.graph.missing_packages import missing_packages
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.graph.problems import GraphError, Problem, Problems
from flowabs_nodes.graph.safe_json import MOST_BYTES, parse
from flowabs_nodes.graph.shipped import resolve, shipped
from flowabs_nodes.graph.validate import validate
from flowabs_nodes.io.formats import check_kind
from flowabs_nodes.io.settings import refuse_shell_words
from flowabs_nodes.nodes import catalogue as installed
from flowabs_nodes.nodes.declare import Node

Source = str | os.PathLike[str] | bytes | Mapping[str, Any]


def load(source: Source, catalogue: Mapping[str, Node] | None = None) -> Graph:
    """Read and validate a graph.

    Parameters
    ----------
    source
        A path, the name of a shipped graph (a text without "/" that does not end in ".json"), JSON as bytes, or a dict.
    catalogue
        Node declarations by type; all that are installed unless given.

    Raises
    ------
    GraphError
        If the graph is not valid; ``problems`` holds everything that is wrong with it.
    CommandError
        If the file cannot be read, or there is no such graph.
    ArgumentError
        If ``source`` is none of these.
    """
    graph, problems, file = _read(source, catalogue)
    if graph is None:
        raise GraphError(problems, file=file or None)
    return graph


def check(source: Source, catalogue: Mapping[str, Node] | None = None) -> list[Problem]:
    """Return everything that is wrong with a graph, warnings included, where :func:`load` would raise GraphError.

    A package that a node needs and that is not installed here is an error too, as for a run; such a graph still loads.
    """
    graph, problems, _ = _read(source, catalogue)
    return problems if graph is None else [*missing_packages(graph.nodes.values()), *problems]


def _read(source: Source, catalogue: Mapping[str, Node] | None) -> tuple[Graph | None, list[Problem], str]:
    problems = Problems()
    file = ""
    try:
        if isinstance(source, Mapping):
            document = jsonable(source, problems)
        elif isinstance(source, bytes):
            document = parse(source, problems)
        else:
            path = _path(source)
            file = str(path)
            document = parse(_bytes(path), problems)
        graph = validate(document, installed() if catalogue is None else catalogue, problems, file)
    except GraphError as error:
        return None, [*problems.found, *error.problems], file
    return graph, problems.found, file


def _path(source: Any) -> Path:
    """Return the file that a path, or the name of a shipped graph, stands for; ArgumentError for anything else."""
    if isinstance(source, str):
        return resolve(source)
    if isinstance(source, os.PathLike):
        return Path(os.fsdecode(source))
    raise ArgumentError(
        "source: expected a path, the name of a graph that comes with flowabs, JSON as bytes, or a dict, "
        f"found {'None' if source is None else type(source).__name__}",
        code="wrong-type",
        parameter="source",
    )


def _bytes(path: Path) -> bytes:
    """Read the file, at most one byte more than a graph may have; a pipe or a device might never end."""
    refuse_shell_words(str(path))
    try:
        check_kind(path)
        with path.open("rb") as file:
            return file.read(MOST_BYTES + 1)
    except (OSError, ValueError, ReadError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or getattr(error, "message", None) or str(error)
        reason = reason.removeprefix("cannot be read: ")
        hint = f"the graph that comes with flowabs is {path.stem!r}" if path.stem in shipped() else ""
        raise CommandError(
            f"cannot read the graph: {reason}",
            code="unreadable-graph",
            file=str(path),
            hint=hint,
        ) from error
