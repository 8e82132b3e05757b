"""Render a .blend, and composite what a graph makes of each frame.

::

    blender -b shot.blend --python composite.py -- abstraction /shots/010/flowabs/
"""

from __future__ import annotations

import sys

import bpy

try:
    from bl_ext.user_default import flowabs_blender  # the installed extension
except ImportError:
    import flowabs_blender  # a folder on the path, where bpy is a module

preset, folder = sys.argv[sys.argv.index("--") + 1 :]

bpy.ops.flowabs.new_from_preset(preset=preset)
passes = bpy.context.scene
composite = flowabs_blender.set_up_compositing(passes, bpy.data.node_groups[preset], folder=folder)
for scene in (passes, composite):
    bpy.ops.render.render(animation=True, scene=scene.name)
if composite.flowabs_compositing.problems:  # a line for each frame that failed
    sys.exit(composite.flowabs_compositing.problems)
