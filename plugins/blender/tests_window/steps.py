"""Lets a script use Blender's window step by step: between two steps Blender draws, and answers its user."""

from __future__ import annotations

import json
import sys
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy

#: A script's steps: yields the seconds to wait until the next one, and returns what the test is told.
Steps = Iterator[float]

_told, _given = sys.argv[sys.argv.index("--") + 1 :]
GIVEN: dict[str, Any] = json.loads(_given)


def play(steps: Callable[[dict[str, Any]], Steps]) -> None:
    """Play the steps once Blender has opened its window, and close it after the last.

    ``steps`` is given a dict, for what the test is to be told.
    """
    import flowabs_blender

    bpy.context.preferences.view.show_splash = False
    flowabs_blender.register()
    told: dict[str, Any] = {}
    left = steps(told)

    def go() -> float | None:
        try:
            return next(left)
        except StopIteration:
            Path(_told).write_text(json.dumps(told), encoding="utf-8")
        except Exception:  # noqa: BLE001 - whatever it is, Blender must not stay open
            traceback.print_exc()
        flowabs_blender.unregister()
        sys.stdout.flush()
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(go, first_interval=1.0)


def window() -> bpy.types.Window:
    """Return Blender's window."""
    return bpy.context.window_manager.windows[0]


def areas() -> list[bpy.types.Area]:
    """Return the areas of the window, the largest first."""
    return sorted(window().screen.areas, key=lambda area: -area.width * area.height)


def open_editors() -> None:
    """Make the largest area a node editor for graphs, and the next one an Image Editor."""
    nodes, image = areas()[:2]
    nodes.type = "NODE_EDITOR"
    nodes.ui_type = "FlowabsTree"
    image.type = "IMAGE_EDITOR"


def within(area: bpy.types.Area) -> Any:
    """Return the context in which an operator is called from an area."""
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def press(key: str) -> None:
    """Press a key and let it go, in the middle of the window."""
    x, y = window().width // 2, window().height // 2
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=x, y=y)


def until(happened: Callable[[], bool], seconds: float, what: str) -> Steps:
    """Wait until something has happened; fails if it has not by then."""
    waited = 0.0
    while not happened():
        if waited > seconds:
            raise TimeoutError(f"{what}: not within {seconds:g} s")
        yield 0.02
        waited += 0.02
