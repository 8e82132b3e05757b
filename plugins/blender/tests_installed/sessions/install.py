"""Installs the extension from disk, as an artist does, and uses it at once."""

import bpy
from blender import GIVEN, is_enabled, pixels_of, tell

bpy.ops.extensions.package_install_files(filepath=GIVEN["zip"], repo="user_default", enable_on_install=True)
bpy.ops.wm.save_userpref()
tell(enabled=is_enabled(), pixels=pixels_of(type="quantize@1"))
