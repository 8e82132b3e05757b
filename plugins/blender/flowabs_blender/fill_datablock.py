"""Puts a flowabs image into one of Blender's: float pixels in Blender's working space, ready for the compositor."""

from __future__ import annotations

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.port_types import TYPES

from .color_names import working_space, working_space_name

#: The custom property of images that are ours to fill again.
MARK = "flowabs_result"


def show(image: Image, name: str) -> bpy.types.Image:
    """Return a datablock with an image's pixels: the one that was filled under this name before, else a new one.

    A picture of somebody else's that has the name keeps it, and the new one is called "name.001". The pixels are those
    of the display window, as a render's are. Colours are premultiplied, in the working space; a mono or matte is
    R = G = B; other types are numbers (Non-Color), depth and ids in R, G and B too. Blender's main thread alone may,
    or a render handler while the interface is locked.

    Raises FlowabsError for data of more than four channels.
    """
    pixels = blender_pixels(image)
    space = None if TYPES[image.type].shown else "Non-Color"
    datablock = _datablock(name, image.display_window.width, image.display_window.height, space)
    datablock.pixels.foreach_set(pixels)
    datablock.update()
    return datablock


def blender_pixels(image: Image) -> Array:
    """Return an image's pixels as Blender holds them: flat float32 R, G, B, A, the lowest row first.

    Any thread may call this. Raises FlowabsError for data of more than four channels.
    """
    image = image.on_window(image.display_window)
    height, width = image.pixels.shape[:2]
    pixels = np.empty((height, width, 4), np.float32)
    if TYPES[image.type].shown:
        image.to_array(colorspace=working_space(), channels="RGBA", rows="bottom-up", out=pixels)
        return pixels.reshape(-1)
    values = image.pixels[::-1]
    count = values.shape[2]
    if count > 4:
        raise FlowabsError(f"an Image of Blender holds four channels, this one has {count}", hint="write it as an EXR")
    pixels[..., :3] = values if count == 1 else 0
    pixels[..., 3] = 1
    pixels[..., :count] = values
    return pixels.reshape(-1)


def _datablock(name: str, width: int, height: int, space: str | None) -> bpy.types.Image:
    """Return our datablock of this name, made or brought to this size; ``space`` None is the working space."""
    datablock = bpy.data.images.get(name)
    if datablock is None or MARK not in datablock or datablock.library is not None:
        datablock = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
        datablock[MARK] = True
        datablock.alpha_mode = "PREMUL"
    if tuple(datablock.size) != (width, height):
        datablock.scale(width, height)
    wanted = working_space_name() if space is None else space
    if datablock.colorspace_settings.name != wanted:
        datablock.colorspace_settings.name = wanted
    return datablock
