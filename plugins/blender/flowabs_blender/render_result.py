"""Takes Blender's last render with all its passes, by saving it: Blender gives nobody its pixels."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

from flowabs_nodes.errors import ReadError

from .color_names import settings_for, working_space
from .taken import Taken

#: How a render is saved so that nothing of it is lost, and fast.
_SETTINGS = {
    "media_type": "MULTI_LAYER_IMAGE",  # Blender 5
    "file_format": "OPEN_EXR_MULTILAYER",
    "color_mode": "RGBA",
    "color_depth": "32",
    "exr_codec": "NONE",
    "use_preview": False,
    "views_format": "MULTIVIEW",
    "color_management": "FOLLOW_SCENE",
}


def take_last_render(scene: bpy.types.Scene) -> Taken:
    """Take the last render, saved where Blender's own temporary files are. For the main thread alone.

    Raises ReadError where nothing was rendered yet.
    """
    working = working_space()
    return Taken(
        name="Render Result",
        file=save_last_render(scene, Path(bpy.app.tempdir) / "flowabs_render.exr"),
        pixels=None,
        content=None,
        space=working.name,
        settings=settings_for(working.name),
        is_data=False,
        is_float=True,
        alpha_mode="PREMUL",
        working=working,
    )


def save_last_render(scene: bpy.types.Scene, file: Path) -> Path:
    """Save the last render as an EXR of all layers and passes, 32 bit; return the file. For the main thread alone.

    Raises ReadError where nothing was rendered yet.
    """
    result = next((image for image in bpy.data.images if image.type == "RENDER_RESULT"), None)
    file.unlink(missing_ok=True)
    try:
        if result is not None:
            with _saving(scene):
                result.save_render(str(file), scene=scene)
    except RuntimeError:  # Blender's way to say that there are no pixels
        result = None
    if result is None or not file.is_file():
        raise ReadError("nothing was rendered yet", code="no-render", hint="Render, Render Image (F12)")
    return file


@contextmanager
def _saving(scene: bpy.types.Scene) -> Iterator[None]:
    """Have a scene's output settings save the whole render, and put them back."""
    settings = scene.render.image_settings
    known = [name for name in _SETTINGS if hasattr(settings, name)]
    before = {name: getattr(settings, name) for name in known}
    try:
        for name in known:
            setattr(settings, name, _SETTINGS[name])
        yield
    finally:
        for name in known:
            setattr(settings, name, before[name])
