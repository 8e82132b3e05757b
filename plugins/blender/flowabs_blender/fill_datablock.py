"""Puts a flowabs image into one of Blender's: float pixels in Blender's working space, ready for the compositor."""

from __future__ import annotations

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.array_types import Array
from flowabs_nodes.color import ColorSpace
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.port_types import TYPES

from .color_names import working_space, working_space_name

#: The custom property of images that are ours to fill again: the name of the picture that they were made of, or "".
MARK = "flowabs_result"

#: The bytes that a datablock's name may have in each version of Blender.
LONGEST_NAME = 63


def show(image: Image, name: str, made_of: str = "") -> bpy.types.Image:
    """Return a datablock with an image's pixels: the one that was filled under this name before, else a new one.

    ``made_of`` names the picture that the graph ran on.

    A picture of somebody else's that has the name keeps it, and the new one is called "name.001". The pixels are those
    of the display window, as a render's are. Colours are premultiplied, in the working space; a mono or matte is
    R = G = B; other types are numbers (Non-Color), depth and ids in R, G and B too. Blender's main thread alone may,
    or a render handler while the interface is locked.

    Raises FlowabsError for data of more than four channels.
    """
    return show_pixels(pixels_for(image, working_space()), TYPES[image.type].shown, name, made_of)


def show_pixels(pixels: Array, are_colors: bool, name: str, made_of: str = "") -> bpy.types.Image:
    """Return a datablock with pixels of :func:`pixels_for`, as :func:`show` does."""
    height, width = pixels.shape[:2]
    datablock = _datablock(name.encode()[:LONGEST_NAME].decode(errors="ignore"), width, height)
    datablock[MARK] = made_of
    space = working_space_name() if are_colors else "Non-Color"
    if datablock.colorspace_settings.name != space:
        datablock.colorspace_settings.name = space
    datablock.pixels.foreach_set(pixels.reshape(-1))
    datablock.update()
    return datablock


def plate_of(datablock: bpy.types.Image) -> bpy.types.Image | None:
    """Return the picture that a result was made of, any other picture itself; None where it is not there any more."""
    return bpy.data.images.get(datablock[MARK]) if datablock.get(MARK) else datablock


def pixels_for(image: Image, working: ColorSpace) -> Array:
    """Return an image's pixels as Blender holds them: (H, W, 4) float32 R, G, B, A, the lowest row first.

    Any thread may call this. Raises FlowabsError for data of more than four channels.
    """
    image = image.on_window(image.display_window)
    height, width = image.pixels.shape[:2]
    pixels = np.empty((height, width, 4), np.float32)
    if TYPES[image.type].shown:
        image.to_array(colorspace=working, channels="RGBA", rows="bottom-up", out=pixels)
        return pixels
    values = image.pixels[::-1]
    count = values.shape[2]
    if count > 4:
        raise FlowabsError(f"an Image of Blender holds four channels, this one has {count}", hint="write it as an EXR")
    pixels[..., :3] = values if count == 1 else 0
    pixels[..., 3] = 1
    pixels[..., :count] = values
    return pixels


def _datablock(name: str, width: int, height: int) -> bpy.types.Image:
    """Return our datablock of this name, made or brought to this size."""
    datablock = bpy.data.images.get(name)
    if datablock is None or MARK not in datablock or datablock.library is not None:
        datablock = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
        datablock.alpha_mode = "PREMUL"
    if tuple(datablock.size) != (width, height):
        datablock.scale(width, height)
    return datablock
