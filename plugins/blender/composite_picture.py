"""Renders the picture of docs/blender.md that shows a frame beside its composite: ``composite_picture.py OUT.jpg``.

For the Python of a ``bpy`` module that has flowabs.
"""

from __future__ import annotations

import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
import OpenImageIO as oiio
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))
import flowabs_blender

from flowabs_nodes.io.read import read_image

SIZE = (600, 450)
SAMPLES = 128


def main(out: str) -> None:
    """Render the shot and its composite, and put both beside each other."""
    flowabs_blender.register()
    scene = make_shot()
    bpy.ops.flowabs.new_from_preset(preset="abstraction")
    tree = bpy.data.node_groups["abstraction"]
    with tempfile.TemporaryDirectory() as folder:
        second = flowabs_blender.set_up_compositing(scene, tree, folder=folder)
        for each in (scene, second):
            bpy.ops.render.render(animation=True, scene=each.name)
        plate = read_image(scene.render.frame_path(frame=1))
        composite = read_image(second.render.frame_path(frame=1))
    halves = [image.to_array(encoding="sRGB", channels="RGB") for image in (plate, composite)]
    picture = oiio.ImageBuf(np.ascontiguousarray(np.concatenate(halves, axis=1)))
    picture.specmod().attribute("CompressionQuality", 93)
    picture.write(out, "uint8")


def make_shot() -> bpy.types.Scene:
    """Return a scene of one frame: a head and toys on a table."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = SAMPLES, False, "CPU"
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.frame_start = scene.frame_end = 1
    scene.view_settings.view_transform = "Standard"
    image_settings = scene.render.image_settings
    image_settings.file_format = "PNG"
    bpy.ops.mesh.primitive_plane_add(size=400)
    paint((0.5, 0.36, 0.22))
    bpy.ops.mesh.primitive_monkey_add(size=2, location=(-0.2, 0, 0.78), rotation=(-0.62, 0, 0.35))
    bpy.context.object.modifiers.new("round", "SUBSURF").render_levels = 3
    bpy.ops.object.shade_smooth()
    paint((0.8, 0.2, 0.03))
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.55, location=(1.75, 0.3, 0.55))
    bpy.ops.object.shade_smooth()
    paint((0.02, 0.12, 0.5))
    bpy.ops.mesh.primitive_torus_add(
        major_segments=128, minor_segments=48, major_radius=0.7, minor_radius=0.24, location=(-1.9, 0.6, 0.24)
    )
    bpy.ops.object.shade_smooth()
    paint((0.05, 0.35, 0.07))
    bpy.ops.mesh.primitive_cube_add(size=0.9, location=(1.1, 1.9, 0.45), rotation=(0, 0, 0.6))
    paint((0.7, 0.62, 0.5))
    bpy.ops.object.light_add(type="SUN", rotation=(0.75, 0.25, 0.6))
    bpy.context.object.data.energy, bpy.context.object.data.angle = 3.2, 0.02
    world = scene.world = bpy.data.worlds.new("sky")
    if bpy.app.version < (5, 0):
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.6, 0.8, 1)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.35
    bpy.ops.object.camera_add(location=(0.3, -6.2, 3.4))
    camera = scene.camera = bpy.context.object
    camera.rotation_euler = (Vector((-0.2, 0.5, 0.45)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    camera.data.angle = math.radians(40)
    return scene


def paint(color: tuple[float, float, float]) -> None:
    """Give the object that was just made a colour."""
    material = bpy.data.materials.new("paint")
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value = 0.6
    bpy.context.object.data.materials.append(material)


if __name__ == "__main__":
    main(sys.argv[1])
