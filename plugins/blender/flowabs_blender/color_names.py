"""Says what the names of Blender's colour spaces mean to flowabs: Blender's config has names that ours lacks."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

import bpy
import OpenImageIO as oiio

from flowabs_nodes.color import ColorSpace
from flowabs_nodes.color.named import find
from flowabs_nodes.errors import ColorError
from flowabs_nodes.io.settings import Settings


def settings_for(name: str) -> Settings:
    """Return settings under which flowabs knows a colour space by Blender's name.

    Raises ColorError for a name that neither flowabs's own config nor Blender's has.
    """
    try:
        find(name)
    except ColorError:
        settings = Settings(ocio=config())
        find(name, settings.ocio)
        return settings
    return Settings()


def working_space() -> ColorSpace:
    """Return the scene-linear space of Blender's float pixels."""
    name = working_space_name()
    return find(name, settings_for(name).ocio).space


def working_space_name() -> str:
    """Return Blender's name of that space: "Linear Rec.709", unless the .blend (Blender 5) or the config says else."""
    if hasattr(bpy.data, "colorspace"):
        return bpy.data.colorspace.working_space
    return _scene_linear(config())


def config() -> str:
    """Return the path of Blender's OpenColorIO config."""
    own = Path(bpy.utils.system_resource("DATAFILES", path="colormanagement")) / "config.ocio"
    return os.environ.get("OCIO") or str(own)


@cache
def _scene_linear(path: str) -> str:
    return oiio.ColorConfig(path).getColorSpaceNameByRole("scene_linear") or "Linear Rec.709"
