"""Makes pictures for the tests, as files and as datablocks, and looks at those of Blender."""

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import OpenImageIO as oiio

RNG = np.random.default_rng(5)


def picture(height: int = 5, width: int = 7, channels: int = 4) -> np.ndarray:
    """Return premultiplied light, part of it above 1."""
    pixels = RNG.uniform(0.1, 2, (height, width, channels)).astype(np.float32)
    if channels == 4:
        pixels[..., 3] = RNG.uniform(0.25, 1, (height, width))
        pixels[..., :3] *= pixels[..., 3:]
    return pixels


def write(path: Path, pixels: np.ndarray, data_type: str = "float", names: Any = None, **header: Any) -> str:
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], data_type)
    if names:
        spec.channelnames = names
    for name, value in header.items():
        setattr(spec, name, value)
    buffer = oiio.ImageBuf(spec)
    buffer.set_pixels(buffer.roi, np.ascontiguousarray(pixels))
    assert buffer.write(str(path)), buffer.geterror()
    return str(path)


def held(datablock: bpy.types.Image) -> np.ndarray:
    """Return the pixels that a datablock holds, the highest row first."""
    pixels = np.empty(len(datablock.pixels), np.float32)
    datablock.pixels.foreach_get(pixels)
    return pixels.reshape(datablock.size[1], datablock.size[0], -1)[::-1]


def made(pixels: np.ndarray, *, is_float: bool = True, name: str = "made") -> bpy.types.Image:
    """Return a datablock of an artist's with these numbers."""
    datablock = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], alpha=True, float_buffer=is_float)
    datablock.pixels.foreach_set(np.ascontiguousarray(pixels[::-1]).ravel())
    return datablock


def rendered(*passes: str) -> bpy.types.Image:
    """Render the empty scene, and return what Blender shows of it; ``passes`` are such as "z"."""
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "CYCLES", 8, 8
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    for name in passes:
        setattr(scene.view_layers[0], f"use_pass_{name}", True)
    bpy.ops.render.render()
    return bpy.data.images["Render Result"]
