"""Counts the changes of each tree, for whoever has to look whether one has changed since."""

from __future__ import annotations

from collections import Counter

import bpy

_changes: Counter[str] = Counter()


def note(tree: bpy.types.NodeTree) -> None:
    """Count a change of a tree's nodes, links or parameters."""
    _changes[tree.name] += 1


def count(tree: bpy.types.NodeTree) -> int:
    """Return how often a tree has changed so far; knobs that were moved are for ``knob_watch.positions``."""
    return _changes[tree.name]
