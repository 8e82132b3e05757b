"""Finds the graphs that come with the package, and the file that a graph's name on the command line means."""

from __future__ import annotations

from pathlib import Path

import flowabs_nodes
from flowabs_nodes.errors import CommandError, nearest


def folder() -> Path:
    """Return the graphs' folder: inside an installed package, or beside it in a checkout (editable installs too)."""
    package = Path(flowabs_nodes.__file__).resolve().parent
    installed = package / "graphs"
    return (
        installed
        if installed.is_dir() or not (package.parent / "pyproject.toml").is_file()
        else package.parent / "graphs"
    )


def shipped() -> dict[str, Path]:
    """Return the file of every graph that comes with the package, by name."""
    return {path.stem: path for path in sorted(folder().glob("*.json"))}


def paper() -> dict[str, Path]:
    """Return the files of the graphs of the paper's figures (``graphs/paper``), by name."""
    return {path.stem: path for path in sorted((folder() / "paper").glob("*.json"))}


def resolve(name: str) -> Path:
    """Return the file that GRAPH means: a path if it has a "/" or ends in ".json", else the shipped graph of that name.

    Raises CommandError, with the nearest name, if no graph of that name comes with the package.
    """
    if "/" in name or "\\" in name or name.endswith(".json"):
        return Path(name)
    known = shipped() | paper()
    if name not in known:
        hint = nearest(name, known)
        if Path(name).is_file():
            hint = f"for the file of that name say ./{name}"
        raise CommandError(f"no graph named {name!r} comes with flowabs", code="unknown-graph", hint=hint)
    return known[name]
