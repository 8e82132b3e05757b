"""A shot to render in a moment: a red ball that rolls over a floor in front of the camera, in Cycles, of 1 sample."""

from pathlib import Path
from typing import Any

import bmesh
import bpy
from mathutils import Vector

SIZE = (48, 27)
FRAMES = (1, 2, 3)


def make(*, size: tuple[int, int] = SIZE, samples: int = 1) -> Any:
    """Return the scene, in place of all that is in the file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.use_denoising = samples, False
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.frame_start, scene.frame_end = FRAMES[0], FRAMES[-1]
    ball = _add(scene, "ball", _mesh(lambda mesh: bmesh.ops.create_icosphere(mesh, subdivisions=4, radius=1)))
    _color(ball, (0.8, 0.08, 0.03, 1))
    for frame, place in ((FRAMES[0], -1.5), (FRAMES[-1], 1.5)):
        ball.location = place, 0, 1
        ball.keyframe_insert("location", frame=frame)
    floor = _add(scene, "floor", _mesh(lambda mesh: bmesh.ops.create_grid(mesh, size=8)))
    _color(floor, (0.3, 0.45, 0.5, 1))
    sun = _add(scene, "sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 4, (0.7, 0.4, 0)
    camera = _add(scene, "camera", bpy.data.cameras.new("camera"))
    camera.location = 0, -8, 3.5
    camera.rotation_euler = Vector((0, 8, -2.7)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    return scene


def render(scene: Any) -> None:
    """Render all frames of a scene."""
    bpy.ops.render.render(animation=True, scene=scene.name)


def as_float(scene: Any) -> None:
    """Have a scene write its pictures without loss."""
    format = scene.render.image_settings
    if "media_type" in format.bl_rna.properties:
        format.media_type = "IMAGE"
    format.file_format, format.color_mode, format.color_depth = "OPEN_EXR", "RGBA", "32"


def frame_file(pattern: str, frame: int) -> Path:
    """Return the file of a frame: "a_0001.exr" of "a_####" and "a_####.exr"."""
    return Path(pattern.replace("####", f"{frame:04d}").removesuffix(".exr") + ".exr")


def _add(scene: Any, name: str, data: Any) -> Any:
    made = bpy.data.objects.new(name, data)
    scene.collection.objects.link(made)
    return made


def _mesh(build: Any) -> Any:
    data, mesh = bpy.data.meshes.new("mesh"), bmesh.new()
    build(mesh)
    mesh.to_mesh(data)
    mesh.free()
    return data


def _color(thing: Any, color: tuple[float, ...]) -> None:
    material = bpy.data.materials.new(thing.name)
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = color
    thing.data.materials.append(material)
