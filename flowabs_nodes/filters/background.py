"""Which depths of a render are its background, where no surface is."""

from __future__ import annotations

#: The depth of what is infinitely far away, in scene units, as Blender has it: finite, so that 1/Z and means are too.
FAR = 1e10
#: From here on a depth is background: renderers write their largest float, or a round number.
BACKGROUND = 1e9
