"""Take a picture of a graph in Blender's node editor, for the docs; Blender itself runs this, in a window.

With the package installed for the Python that Blender has (Debian's Blender has the system's)::

    PYTHONPATH=PACKAGES blender --python-use-system-env --factory-startup --window-geometry 0 0 1600 800 \
        --python plugins/blender/screenshot.py -- abstraction docs/pictures/blender.png

Without a display: ``LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -s '-screen 0 1600x800x24 +extension GLX' blender ...``.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import bpy

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[2])]

PAUSE = 0.7  # seconds in which Blender draws


def steps(preset: str, file: Path) -> Iterator[None]:
    """Build the screen step by step; between the steps Blender draws."""
    import flowabs_blender
    from flowabs_blender import knobs_panel

    for panel in knobs_panel.CLASSES:  # a script cannot choose a tab of the sidebar: the first one is shown
        panel.bl_category = "Node"
    flowabs_blender.register()
    area = _largest()
    area.type = "NODE_EDITOR"
    area.ui_type = "FlowabsTree"
    yield
    with _in_editor():
        bpy.ops.flowabs.new_from_preset(preset=preset)
    tree = area.spaces.active.node_tree
    for node in tree.nodes:
        node.select = True
    tree.nodes.active = tree.nodes.get("lines", tree.nodes[0])
    area.spaces.active.show_region_ui = True
    yield
    with _in_editor():
        bpy.ops.screen.screen_full_area(use_hide_panels=False)
    yield
    with _in_editor():
        bpy.ops.node.view_selected()
    yield
    for _ in range(4):
        with _in_editor():
            bpy.ops.view2d.zoom_in()
        yield
    for node in tree.nodes:
        node.select = node == tree.nodes.active
    yield
    with _in_editor():
        bpy.ops.screen.screenshot_area(filepath=str(file.resolve()))


def _window() -> Any:
    return bpy.context.window_manager.windows[0]


def _largest() -> Any:
    return max(_window().screen.areas, key=lambda area: area.width * area.height)


def _in_editor() -> Any:
    area = _largest()
    region = next(region for region in area.regions if region.type == "WINDOW")
    return bpy.context.temp_override(window=_window(), area=area, region=region)


def go() -> float | None:
    """Do the next step, and leave Blender after the last."""
    try:
        next(ALL)
    except StopIteration:
        bpy.ops.wm.quit_blender()
        return None
    except Exception:  # noqa: BLE001 - whatever it is, Blender must not stay open
        traceback.print_exc()
        bpy.ops.wm.quit_blender()
        return None
    return PAUSE


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :]
    bpy.context.preferences.view.show_splash = False
    ALL = steps(arguments[0], Path(arguments[1]))
    bpy.app.timers.register(go, first_interval=PAUSE)
