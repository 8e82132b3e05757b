"""Try a knob at several values, small, to choose one by eye: one Image for each value.

::

    blender shot.blend --python try_knobs.py -- abstraction line_amount 0.2 0.5 0.8

The graph is a node tree of the .blend, or one that comes with flowabs; the plate is the .blend's Image "plate".
"""

from __future__ import annotations

import sys

import bpy

try:
    from bl_ext.user_default import flowabs_blender  # the installed extension
except ImportError:
    import flowabs_blender  # a folder on the path, where bpy is a module

graph, knob, *values = sys.argv[sys.argv.index("--") + 1 :]

for value in map(float, values):
    flowabs_blender.run(graph, bpy.data.images["plate"], set={knob: value}, scale=0.25, name=f"{knob} {value:g}")
