"""Runs a graph on a large picture, and presses Esc while it is at work."""

import time
from typing import Any

import bpy
import steps


def play(told: dict[str, Any]) -> steps.Steps:
    from flowabs_blender import background

    steps.open_editors()
    nodes = steps.areas()[0]
    bpy.data.images.new("large", 4096, 2304, float_buffer=True).generated_type = "COLOR_GRID"
    yield 0.5
    with steps.within(nodes):
        bpy.ops.flowabs.new_from_preset(preset="abstraction")
        bpy.ops.flowabs.run("INVOKE_DEFAULT", image="large")
    told["begun"] = len(background.at_work())
    watch = steps.Watch()
    yield 1.5
    told["still_at_work"] = len(background.at_work())
    bpy.ops.screen.screenshot(filepath=steps.GIVEN["picture"])
    watch.longest = 0.0
    yield 0.5
    told["longest_gap"] = watch.longest
    steps.press("ESC")
    pressed = time.monotonic()
    yield from steps.until(lambda: not background.at_work(), 10, "the end of the work")
    told["seconds"] = time.monotonic() - pressed
    yield 0.3
    told["results"] = [image.name for image in bpy.data.images if image.name.startswith("abstraction")]


steps.play(play)
