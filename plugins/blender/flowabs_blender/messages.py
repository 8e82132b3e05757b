"""Says in the words of Blender's report area what went wrong."""

from __future__ import annotations

from flowabs_nodes.choices import readable
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.graph import GraphError, Problem

from .problems import in_short, parts

MOST = 5  # problems of a graph that one message names

#: What to do in Blender, by an error's code, in place of a hint for the command line.
_HINTS = {
    "file-not-set": "set the node's file, or run on a picture that is a file with such a pass",
    "foreign-file": "choose another folder, or Overwrite",
    "exists": "choose Resume or Overwrite",
    "no-write": "choose an output, or add a Write node",
}

#: What else may help in Blender, beside the hint.
_PASSES = "a render has the passes that are on under View Layer Properties, Passes"
_MORE = {"no-layer": _PASSES, "unknown-layer": _PASSES}


def message(error: FlowabsError) -> str:
    """Return an error as one line: of a graph the first problems, each with its node."""
    if isinstance(error, GraphError):
        wrong = [problem for problem in error.problems if not problem.warning]
        more = f"; and {len(wrong) - MOST} more" if len(wrong) > MOST else ""
        return "the graph cannot run: " + "; ".join(map(_problem, wrong[:MOST])) + more
    hint = error.hint
    error.hint = "; ".join(filter(None, [_HINTS.get(error.code, hint), _MORE.get(error.code)]))
    try:
        return " ".join(str(error).split())
    finally:
        error.hint = hint


def _problem(problem: Problem) -> str:
    place = parts(problem.pointer)
    if place[:1] == ["nodes"] and len(place) > 1:
        return f"{place[1]}: {in_short(problem, place[2:])}"
    return f"{readable('.'.join(place)) or 'Graph'}: {in_short(problem, place)}"
