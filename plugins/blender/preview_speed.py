"""Measure how long the live preview takes, from a slider to the Image datablock: 1080p at half size.

With the Python of an environment of ``python -m tools.blender``, or in Blender::

    CACHE/blender-4.5/bin/python plugins/blender/preview_speed.py

Beside the time stands that of the processors, which other programs on the machine do not change: halved, it is about
what two idle processors take.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Sequence
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

import bpy  # noqa: E402
import flowabs_blender  # noqa: E402
from flowabs_blender import fill_datablock, preview  # noqa: E402

import flowabs_nodes as fa  # noqa: E402
from flowabs_nodes.comp.resizing import resized  # noqa: E402
from flowabs_nodes.image import Window  # noqa: E402
from flowabs_nodes.io.read import read_image  # noqa: E402

PLATE = HERE.parents[1] / "docs" / "pictures" / "coffee.exr"

#: What a knob of "abstraction" makes anew, the knob, and where it is put.
TURNS: Sequence[tuple[str, str, Sequence[float]]] = (
    ("the last node", "ink_opacity", [0.1 * step for step in range(1, 10)]),
    ("the lines", "line_width", [0.5 + 0.2 * step for step in range(9)]),
    ("everything", "coherence", [1.25 + 0.5 * step for step in range(9)]),
)


def main() -> None:
    """Turn each knob several times and print the medians."""
    flowabs_blender.register()
    full = Window(0, 0, 1920, 1080)
    plate = fill_datablock.show(resized(read_image(PLATE), full, full, "lanczos3", overshoot=False), "plate")
    del plate[fill_datablock.MARK]  # a picture like any other
    bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = bpy.data.node_groups["abstraction"]
    tree.run_settings.image, tree.run_settings.scale = plate, "0.5"
    preview.switch(tree, on=True)
    turned(tree, "ink_opacity", 0.95)  # compiles, reads, scales
    for what, knob, places in TURNS:
        turned(tree, knob, places[-1])
        found = [turned(tree, knob, place) for place in places[:-1]]
        seconds, processors = (statistics.median(each) * 1000 for each in zip(*found, strict=True))
        print(f"{what:14} {seconds:4.0f} ms, processors {processors:4.0f} ms", flush=True)
    print(f"Blender {bpy.app.version_string}, flowabs {fa.__version__}")
    flowabs_blender.unregister()


def turned(tree: bpy.types.NodeTree, knob: str, place: float) -> tuple[float, float]:
    """Turn a knob and call the timer, as Blender does, until the picture is there; return seconds and processors'."""
    begin, at_work = time.perf_counter(), time.process_time()
    tree[knob] = place
    preview.tick()
    while not preview.preview_of(tree).settled:
        time.sleep(0.001)
        preview.tick()
    return time.perf_counter() - begin, time.process_time() - at_work


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 as a module sometimes hangs while Python takes itself apart
