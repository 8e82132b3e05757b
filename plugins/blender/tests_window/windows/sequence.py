"""Runs a graph over rendered frames to the end, and again over many, which Esc ends."""

import time
from pathlib import Path
from typing import Any

import bpy
import steps


def play(told: dict[str, Any]) -> steps.Steps:
    from flowabs_blender import background

    nodes, image = steps.open_editors("FlowabsTree", "IMAGE_EDITOR")
    yield 0.5
    with steps.within(nodes):
        bpy.ops.flowabs.new_from_preset(preset="lines")
    # To PNG: beside the OpenEXR of Debian's Blender, that of the wheels crashes when it writes.
    folder = Path(steps.GIVEN["folder"])
    for name, frames in (("whole", "1-3"), ("ended", "1-300")):
        with steps.within(nodes):
            bpy.ops.flowabs.run_sequence(
                "INVOKE_DEFAULT",
                frames_in=str(folder / "shot.####.exr"),
                frames_out=str(folder / f"{name}.####.png"),
                frame_range=frames,
            )
        pressed = time.monotonic()
        if name == "ended":
            yield from steps.until(lambda: list(folder.glob("ended.*.png")), 60, "the first frame")
            steps.press("ESC")
            pressed = time.monotonic()
        yield from steps.until(lambda: not background.at_work(), 90, f"the end of {name}")
        told[f"{name}_seconds"] = time.monotonic() - pressed
        yield 0.5
    told["shown"] = image.spaces.active.image.name


steps.play(play)
