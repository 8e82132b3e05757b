"""Lets a script use Blender's window step by step: between two steps Blender draws, and answers its user."""

from __future__ import annotations

import json
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenImageIO as oiio

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
    for each in flowabs_blender.OPERATORS_AND_PANELS:
        if issubclass(each, bpy.types.Panel):  # a script cannot choose a tab of a sidebar: this one is shown
            each.bl_category = "Tool"
            each.bl_options = set()
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
        sys.stdout.flush()
        bpy.ops.wm.quit_blender()
        return None

    bpy.app.timers.register(go, first_interval=1.0)


def window() -> bpy.types.Window:
    """Return Blender's window."""
    return bpy.context.window_manager.windows[0]


def open_editors(*kinds: str) -> list[bpy.types.Area]:
    """Make the largest areas of the window editors of these kinds, and return them."""
    areas = sorted(window().screen.areas, key=lambda area: -area.width * area.height)[: len(kinds)]
    for area, kind in zip(areas, kinds, strict=True):
        area.ui_type = kind
    return areas


def within(area: bpy.types.Area) -> Any:
    """Return the context in which an operator is called from an area."""
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=window(), area=area, region=region)


def press(key: str) -> None:
    """Press a key and let it go, in the middle of the window."""
    x, y = window().width // 2, window().height // 2
    for value in ("PRESS", "RELEASE"):
        window().event_simulate(type=key, value=value, x=x, y=y)


def until(happened: Callable[[], object], seconds: float, what: str) -> Steps:
    """Wait until something has happened; fails if it has not by then."""
    waited = 0.0
    while not happened():
        if waited > seconds:
            raise TimeoutError(f"{what}: not within {seconds:g} s")
        yield 0.02
        waited += 0.02


class Watch:
    """Notes how long Blender was busy with something else at a time: then it answers nobody."""

    def __init__(self) -> None:
        self.restart()
        bpy.app.timers.register(self._tick)

    def restart(self) -> None:
        """Forget what was."""
        self.longest, self._last = 0.0, time.monotonic()

    def _tick(self) -> float:
        now = time.monotonic()
        self.longest, self._last = max(self.longest, now - self._last), now
        return 0.01


def find_slider(area: bpy.types.Area, tree: bpy.types.NodeTree, knob: str, end: float, found: list[int]) -> Steps:
    """Find a knob's slider in the sidebar of an area: what is drawn anew there when the knob moves to its end.

    Adds x and y, in the window, of a place on the filled part to ``found``.
    """
    value, pictures = tree[knob], []
    for there in (end, value):
        tree[knob] = there
        area.tag_redraw()
        yield 0.5
        pictures.append(screenshot(Path(bpy.app.tempdir) / "sidebar.png"))
    sidebar = next(region for region in area.regions if region.type == "UI")
    rows, columns = np.nonzero((pictures[0] != pictures[1]).any(-1)[:, sidebar.x :])
    found += [sidebar.x + int(columns.min()) - 4, int(np.median(rows))]


def screenshot(file: Path) -> np.ndarray:
    """Take a picture of the window, which stays in the file; return its pixels, the lowest row first."""
    bpy.ops.screen.screenshot(filepath=str(file))
    return oiio.ImageBuf(str(file)).get_pixels(oiio.UINT8)[::-1]


def drag(x: int, y: int, along: int, count: int) -> Steps:
    """Press the mouse, move it along in as many steps, and let it go."""
    window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x, y=y)
    yield 0.1
    window().event_simulate(type="LEFTMOUSE", value="PRESS", x=x, y=y)
    for number in range(1, count + 1):
        yield 0.05
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=x + along * number // count, y=y)
    yield 0.05
    window().event_simulate(type="LEFTMOUSE", value="RELEASE", x=x + along, y=y)
