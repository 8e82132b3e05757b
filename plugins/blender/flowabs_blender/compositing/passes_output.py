"""Sends a scene's render to EXR files with all passes, and sets its output back to what it was."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import bpy

from . import compositor

#: What decides the files of a render; of a format, those that come first decide what the others may be.
_RENDER = ("filepath", "use_file_extension")
_FORMAT = ("media_type", "file_format", "color_mode", "color_depth", "exr_codec")
_PASSES = {
    "media_type": "MULTI_LAYER_IMAGE",
    "file_format": "OPEN_EXR_MULTILAYER",
    "color_depth": "32",  # ids and depth are no halves
    "exr_codec": "ZIP",
    "views_format": "MULTIVIEW",
}
_PICTURE = {"media_type": "IMAGE", "file_format": "OPEN_EXR", "color_mode": "RGBA", "color_depth": "16"}
_LOOK = ("view_transform", "exposure", "gamma", "look")


def send(scene: bpy.types.Scene, passes: str, were_off: Mapping[str, list[str]]) -> None:
    """Have a scene render all passes to files, and remember what it did before.

    ``were_off`` are the passes that were switched on for it, by view layer. What is remembered already stays.
    """
    settings = scene.flowabs_compositing
    before = json.loads(settings.before) if settings.before else {**_output(scene), "off": {}, "node": ""}
    for layer, switches in were_off.items():
        before["off"].setdefault(layer, []).extend(switches)
    before["node"] = before["node"] or compositor.keep_passes(scene)
    before["sent to"] = passes
    settings.before = json.dumps(before)
    scene.render.filepath = passes
    scene.render.use_file_extension = True
    set_known(scene.render.image_settings, _PASSES)


def take_back(scene: bpy.types.Scene) -> None:
    """Set a scene's output and passes back to what they were; an output that was changed since stays."""
    settings = scene.flowabs_compositing
    if not settings.before:
        return
    before = json.loads(settings.before)
    if scene.render.filepath == before["sent to"]:
        set_known(scene.render, before["render"])
        for part in ("views", "format"):  # a picture of one layer may not stay in "several views"
            set_known(scene.render.image_settings, before[part])
    for layer, switches in before["off"].items():
        for switch in switches if layer in scene.view_layers else ():
            setattr(scene.view_layers[layer], switch, False)
    compositor.drop_node(scene, before["node"])
    settings.before = ""


def copy_kind(first: bpy.types.Scene, second: bpy.types.Scene) -> None:
    """Give a new scene the kind of picture that another one renders, and its look; a single layer for several."""
    kind = _output(first)["format"]
    set_known(second.render.image_settings, _PICTURE if kind["file_format"] == "OPEN_EXR_MULTILAYER" else kind)
    second.display_settings.display_device = first.display_settings.display_device
    set_known(second.view_settings, {name: getattr(first.view_settings, name) for name in _LOOK})


def _output(scene: bpy.types.Scene) -> dict[str, Any]:
    """Return what decides the files of a scene's render."""
    format = scene.render.image_settings
    return {
        "render": {name: getattr(scene.render, name) for name in _RENDER},
        "format": {name: getattr(format, name) for name in _FORMAT if name in format.bl_rna.properties},
        "views": {"views_format": format.views_format},
    }


def set_known(owner: Any, values: Mapping[str, Any]) -> None:
    """Set those properties that this Blender has."""
    for name, value in values.items():
        if name in owner.bl_rna.properties:
            setattr(owner, name, value)
