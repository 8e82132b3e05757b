"""Run a graph over rendered frames, while a knob moves: lines that grow thicker from the first frame to the last.

::

    blender -b --python frames.py -- 'shot.####.exr' 'lines.####.exr' 1001 1100

Frames that are there already, and were made of the same, are kept: run it again after a stop.
"""

from __future__ import annotations

import sys

import bpy

try:
    from bl_ext.user_default import flowabs_blender  # the installed extension
except ImportError:
    import flowabs_blender  # a folder on the path, where bpy is a module

if not hasattr(bpy.types.Scene, "flowabs_tree"):  # where bpy is a module
    flowabs_blender.register()

frames_in, frames_out, first, last = sys.argv[sys.argv.index("--") + 1 :]

bpy.ops.flowabs.new_from_preset(preset="lines")
tree = bpy.context.scene.flowabs_tree  # the scene's, since it has no other: its keyframes count
for frame, width in ((int(first), 0.5), (int(last), 2.0)):
    tree["line_width"] = width
    tree.keyframe_insert('["line_width"]', frame=frame)

bpy.ops.flowabs.run_sequence(frames_in=frames_in, frames_out=frames_out, frame_range=f"{first}-{last}")
