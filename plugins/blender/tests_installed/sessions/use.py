"""Uses the extension in a session in which it is enabled from the start."""

from blender import is_enabled, pixels_of, read_preferences, tell

read_preferences()
pixels = pixels_of(type="quantize@1")

import numba  # noqa: E402 - now they are those that Blender found
import numpy  # noqa: E402
import OpenImageIO  # noqa: E402

import flowabs_nodes  # noqa: E402

packages = {module.__name__: module.__file__ for module in (flowabs_nodes, numba, numpy, OpenImageIO)}
tell(enabled=is_enabled(), pixels=pixels, packages=packages)
