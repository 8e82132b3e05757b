"""Removes the extension."""

import bpy
from blender import is_enabled, read_preferences, tell

read_preferences()
was_enabled = is_enabled()
repositories = [repository.module for repository in bpy.context.preferences.extensions.repos]
bpy.ops.extensions.package_uninstall(repo_index=repositories.index("user_default"), pkg_id="flowabs_blender")
bpy.ops.wm.save_userpref()
tell(was_enabled=was_enabled, enabled=is_enabled())
