"""Uses a node of another package, installed beside Blender's own packages, and looks for it in the Add menu."""

import sys

from blender import GIVEN, pixels_of, read_preferences, tell

sys.path.append(GIVEN["packages"])
read_preferences()

from bl_ext.user_default.flowabs_blender import add_menu  # noqa: E402

tell(tones=[node.type for node in add_menu.by_category()["tone"]], pixels=pixels_of(type="duotone@1"))
