"""``flowabs run GRAPH --dry-run``: tells what a run would read, write and do, and makes nothing."""

from __future__ import annotations

import json

from flowabs_nodes.cli.progress import JsonLines, Lines, Loudness
from flowabs_nodes.engine.options import RunOptions
from flowabs_nodes.errors import FlowabsError


def tell_plan(graph: str, options: RunOptions, show: Lines) -> int:
    """Tell what a run would do with each frame; return 1 where one will surely fail, else 0.

    Raises FlowabsError, as a run does, where the graph or the command is wrong.
    """
    from flowabs_nodes.cli.summary import frames_in_words
    from flowabs_nodes.engine.dry_run import MEANINGS, NOT_KNOWN, dry_run
    from flowabs_nodes.engine.notes import frame_range

    as_json = isinstance(show, JsonLines)
    try:
        plan = dry_run(graph, options)
    except FlowabsError as error:
        show.error(error)
        raise
    frames: dict[tuple[str, str], list[int]] = {}  # by state and reason
    for each in plan.plans:
        why = "" if each.error is None else each.error.reason
        frames.setdefault((each.state, why), []).append(each.frame)
        if as_json:
            print(json.dumps(each.event()))
        elif show.loudness == Loudness.VERBOSE:
            files = [
                f"{what} {', '.join(paths)}"
                for what, paths in (("reads", each.reads), ("writes", each.writes))
                if paths
            ]
            show.line("  ".join([f"frame {each.frame}  {each.state:8}", *files]).rstrip())
    counts: dict[str, int] = {
        state: sum(len(found) for (each, _), found in frames.items() if each == state) for state in MEANINGS
    }
    if as_json:
        event = {"event": "dry-run", "graph": plan.graph, "frames": len(plan.frames), **counts}
        print(json.dumps({**event, "reads": plan.reads, "writes": plan.writes, "about": NOT_KNOWN}), flush=True)
        return int(counts["fail"] > 0)
    loud = show.loudness > Loudness.QUIET
    if loud:
        for what, patterns in (("reads", plan.reads), ("writes", plan.writes)):
            for pattern in patterns:
                show.line(f"{what:6}  {pattern}")
    for state, meaning in MEANINGS.items():
        for (each_state, why), found in frames.items():
            if each_state == state and (loud or state in ("fail", "other")):
                words = frames_in_words(frame_range(found), len(found))
                show.line(
                    f"{len(found):6}  {meaning}{f', {why}' if why else ''}: {words}", error=state in ("fail", "other")
                )
    if loud:
        show.line(f"Nothing was made. {NOT_KNOWN}")
    return int(counts["fail"] > 0)
