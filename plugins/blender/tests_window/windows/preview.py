"""Switches the live preview on and drags a knob's slider with the mouse, while the preview follows."""

import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import steps


def play(told: dict[str, Any]) -> steps.Steps:
    from flowabs_blender import preview, run_panels

    bpy.utils.unregister_class(run_panels.FLOWABS_PT_image_run)  # it grows later, and would move the slider
    image, nodes = steps.open_editors("IMAGE_EDITOR", "FlowabsTree")
    image.spaces.active.image = bpy.data.images.load(steps.GIVEN["plate"])
    image.spaces.active.show_region_ui = True
    yield 0.5
    with steps.within(nodes):
        bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = nodes.spaces.active.node_tree
    yield 0.5
    slider: list[int] = []
    yield from steps.find_slider(image, tree, "line_width", 2.5, slider)
    with steps.within(image):
        bpy.ops.flowabs.preview()
    on = preview.preview_of(tree)
    yield from steps.until(lambda: on.seconds > 0 or on.problem, 90, "the first preview")
    told["problem"] = on.problem
    told["shown"] = image.spaces.active.image.name
    yield 0.5

    before, seen = tree["line_width"], [_pixels()]
    watch = steps.Watch()
    for pause in steps.drag(*slider, 60, 20):
        yield pause
        if (pixels := _pixels()) != seen[-1]:
            seen.append(pixels)
    told["while_dragged"] = len(seen) - 1
    told["longest_gap"] = watch.longest
    released = time.monotonic()
    yield from steps.until(lambda: on.resting, 20, "the last preview")
    told["resting_after"] = time.monotonic() - released
    told["moved"] = (before, tree["line_width"])
    yield 0.3
    steps.screenshot(Path(steps.GIVEN["picture"]))


def _pixels() -> int:
    """Return a digest of the preview's pixels."""
    image = bpy.data.images["abstraction preview"]
    pixels = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(pixels)
    return hash(pixels.tobytes())


steps.play(play)
