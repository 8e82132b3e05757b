"""Take a picture of a graph in Blender's node editor beside its result, for the docs; Blender runs this, in a window.

With the package installed for the Python that Blender has (Debian's Blender has the system's)::

    PYTHONPATH=PACKAGES blender --python-use-system-env --factory-startup --window-geometry 0 0 1800 1000 \
        --python plugins/blender/screenshot.py -- abstraction docs/pictures/blender.png

Without a display: ``LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -s '-screen 0 1800x1000x24 +extension GLX' blender ...``.
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
PLATE = Path(__file__).parents[2] / "docs" / "pictures" / "coffee.exr"


def steps(preset: str, file: Path) -> Iterator[None]:
    """Build the screen step by step; between the steps Blender draws."""
    import flowabs_blender
    from flowabs_blender import knobs_panel

    for panel in knobs_panel.CLASSES:  # a script cannot choose a tab of the sidebar: Tool is the one that is shown
        panel.bl_category = "Tool"
    flowabs_blender.register()
    area = _largest()
    area.type = "NODE_EDITOR"
    area.ui_type = "FlowabsTree"
    yield
    with _inside(area):
        bpy.ops.flowabs.new_from_preset(preset=preset)
    tree = area.spaces.active.node_tree
    tree.nodes.active = tree.nodes.get("lines", tree.nodes[0])
    result = flowabs_blender.run(tree, str(PLATE))
    yield
    with _inside(area):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.62)
    graph, picture = sorted((each for each in _window().screen.areas if each.type == "NODE_EDITOR"), key=lambda a: a.x)
    graph.spaces.active.show_region_ui = True
    picture.type = "IMAGE_EDITOR"
    picture.spaces.active.image = result
    yield
    with _inside(picture):
        bpy.ops.image.view_all(fit_view=True)
    for node in tree.nodes:
        node.select = True
    with _inside(graph):
        bpy.ops.node.view_selected()
    yield
    for node in tree.nodes:
        node.select = node == tree.nodes.active
    yield
    with _inside(graph):
        bpy.ops.screen.screenshot(filepath=str(file.resolve()))


def _window() -> Any:
    return bpy.context.window_manager.windows[0]


def _largest() -> Any:
    return max(_window().screen.areas, key=lambda area: area.width * area.height)


def _inside(area: Any) -> Any:
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
