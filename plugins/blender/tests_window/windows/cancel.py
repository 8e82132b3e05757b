"""Runs a graph on a large picture, and presses Esc while it is at work."""

import time
from pathlib import Path
from typing import Any

import bpy
import steps


def play(told: dict[str, Any]) -> steps.Steps:
    from flowabs_blender import background

    (nodes,) = steps.open_editors("FlowabsTree")
    bpy.data.images.new("large", 2400, 2400, float_buffer=True).generated_type = "COLOR_GRID"
    yield 0.5
    with steps.within(nodes):
        bpy.ops.flowabs.new_from_preset(preset="abstraction")
        bpy.ops.flowabs.run(image="large")  # and so all filters are compiled
        bpy.data.images.remove(bpy.data.images["abstraction comp"])
        bpy.ops.flowabs.run("INVOKE_DEFAULT", image="large")
    (work,) = background.at_work()
    watch = steps.Watch()
    yield from steps.until(lambda: "pre" in work.text, 60, "the node in the middle")
    told["longest_gap"] = watch.longest
    told["at_work"] = work.running
    steps.press("ESC")
    pressed = time.monotonic()
    yield from steps.until(lambda: not background.at_work(), 10, "the end of the work")
    told["seconds"] = time.monotonic() - pressed
    steps.screenshot(Path(steps.GIVEN["picture"]))
    told["results"] = [image.name for image in bpy.data.images if image.name.startswith("abstraction")]


steps.play(play)
