"""Run a graph on a picture, with other knobs than its own; the result is an Image of the .blend, and an EXR.

::

    blender -b --python picture.py -- plate.exr lines.exr
"""

from __future__ import annotations

import sys

import bpy

try:
    from bl_ext.user_default import flowabs_blender  # the installed extension
except ImportError:
    import flowabs_blender  # a folder on the path, where bpy is a module

plate, file = sys.argv[sys.argv.index("--") + 1 :]

result = flowabs_blender.run(
    "abstraction",
    bpy.data.images.load(plate),  # or just the path
    set={"line_width": 1.5, "flat.softness": 0.5},
    file=file,
    name="drawn",
)
print(f"{result.name}: {result.size[0]} x {result.size[1]}, {result.colorspace_settings.name}")
