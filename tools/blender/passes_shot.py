"""Render the shot with passes of ``tests/data/blender``: ``PYTHON -m tools.blender.passes_shot FOLDER``.

PYTHON is one with bpy, as those of ``python -m tools.blender`` are. Three frames of 96x54, of things that
are there so that each kind of edge is: a stripe of another material on a box (a material edge), a box that stands flush
against it (two objects without a step in depth), a ball half sunk into the floor (an intersection), a bent sheet
(creases of 90, 50 and 25 degrees), a ring (a surface in front of itself), and sky. The ball rolls and the camera moves.
Each file has every pass that the nodes for passes read.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import bpy  # type: ignore[import-not-found]
from mathutils import Vector  # type: ignore[import-not-found]

WIDTH = 96
FRAMES = (1, 2, 3)
SAMPLES = 16

#: Base colours of materials; their pass index is the place here, from 1.
MATERIALS = {
    "floor": (0.42, 0.4, 0.36),
    "crate": (0.75, 0.5, 0.2),
    "stripe": (0.1, 0.3, 0.6),
    "cabinet": (0.3, 0.5, 0.35),
    "ball": (0.8, 0.1, 0.05),
    "sheet": (0.7, 0.65, 0.6),
    "ring": (0.5, 0.25, 0.55),
}


class Shape(NamedTuple):
    """The vertices of a thing, and the places of those of each face."""

    vertices: Sequence[tuple[float, float, float]]
    faces: Sequence[tuple[int, ...]]


def make() -> Any:
    """Return the scene, in place of all that is in the file."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    for index, (name, color) in enumerate(MATERIALS.items(), 1):
        _material(name, color, index)
    _add(scene, "floor", _floor(), "floor")
    crate = _add(scene, "crate", _box(), "crate", "stripe")
    crate.location, crate.rotation_euler[2] = (-1.6, 0.6, 0.8), 0.5
    crate.scale = (0.8, 0.8, 0.8)
    for face in crate.data.polygons:
        face.material_index = int(abs(face.center.z) < 0.2)  # the middle row of faces
    cabinet = _add(scene, "cabinet", _box(), "cabinet")
    cabinet.rotation_euler[2], cabinet.scale = 0.5, (0.8, 0.8, 0.55)
    cabinet.location = Vector((-1.6, 0.6, 0.55)) + Vector((math.cos(0.5), math.sin(0.5), 0)) * 1.6  # flush
    ball = _add(scene, "ball", _ball(0.7), "ball")
    ball.data.shade_smooth()
    for frame, x in ((FRAMES[0], 0.3), (FRAMES[-1], 0.9)):
        ball.location = x, -1.2, 0.35
        ball.keyframe_insert("location", frame=frame)
    sheet = _add(scene, "sheet", _sheet((90, 50, 25)), "sheet")
    sheet.location = 1.3, 1.6, 0
    ring = _add(scene, "ring", _ring(0.42, 0.13), "ring")
    ring.data.shade_smooth()
    ring.location, ring.rotation_euler = (-0.4, -1.9, 0.45), (1.2, 0.3, 0)
    for name, energy, turn in (("sun", 3.0, (0.6, 0.35, 0)), ("fill", 0.6, (0.9, -0.5, 0))):
        light = _add(scene, name, bpy.data.lights.new(name, "SUN"))
        light.data.energy, light.data.angle, light.rotation_euler = energy, 0, turn  # sharp shadows have no noise
    camera = _add(scene, "camera", bpy.data.cameras.new("camera"))
    camera.data.lens = 40
    for frame, x in ((FRAMES[0], -0.1), (FRAMES[-1], 0.15)):
        camera.location = x, -7.5, 2.6
        camera.keyframe_insert("location", frame=frame)
    camera.rotation_euler = Vector((0, 7.5, -1.7)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    world = bpy.data.worlds.new("world")
    scene.world = world
    for index, thing in enumerate(scene.objects, 1):
        thing.pass_index = index
    return scene


def render(scene: Any, folder: Path, width: int) -> None:
    """Render the frames, ``width`` pixels wide, to ``FOLDER/passes_VERSION.####.exr`` with all passes that are read."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.max_bounces = SAMPLES, False, 0
    scene.render.resolution_x, scene.render.resolution_y = width, width * 9 // 16
    scene.render.film_transparent = False
    layer = scene.view_layers[0]
    for name in ("z", "normal", "vector", "cryptomatte_object", "cryptomatte_material", "object_index"):
        setattr(layer, f"use_pass_{name}", True)
    layer.use_pass_material_index = True
    layer.pass_cryptomatte_depth = 2  # two ids a pixel: one level
    format = scene.render.image_settings
    if "media_type" in format.bl_rna.properties:
        format.media_type = "MULTI_LAYER_IMAGE"
    format.file_format, format.color_mode, format.color_depth = "OPEN_EXR_MULTILAYER", "RGBA", "16"
    format.exr_codec = "ZIP"
    scene.render.use_file_extension = False
    version = "".join(map(str, bpy.app.version[:2]))
    for frame in FRAMES:
        scene.frame_set(frame)
        scene.render.filepath = str(folder / f"passes_{version}.{frame:04d}.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)


def _material(name: str, color: Sequence[float], index: int) -> None:
    material = bpy.data.materials.new(name)
    material.pass_index = index
    if bpy.app.version < (5, 0):
        material.use_nodes = True
    surface = material.node_tree.nodes["Principled BSDF"]
    surface.inputs["Base Color"].default_value = (*color, 1)
    surface.inputs["Roughness"].default_value = 1
    surface.inputs["Specular IOR Level"].default_value = 0


def _add(scene: Any, name: str, what: Any, *materials: str) -> Any:
    """Put a shape, a light or a camera into the scene."""
    data = what
    if isinstance(what, Shape):
        data = bpy.data.meshes.new(name)
        data.from_pydata(what.vertices, [], what.faces)
    made = bpy.data.objects.new(name, data)
    scene.collection.objects.link(made)
    for each in materials:
        data.materials.append(bpy.data.materials[each])
    return made


def _floor() -> Shape:
    return Shape([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [(0, 1, 2, 3)])


def _box() -> Shape:
    """Return a box from -1 to 1 whose sides are three rows of faces."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    vertices = [(x, y, z) for z in (-1, -0.25, 0.25, 1) for x, y in corners]
    sides = [
        (4 * r + i, 4 * r + (i + 1) % 4, 4 * r + 4 + (i + 1) % 4, 4 * r + 4 + i) for r in range(3) for i in range(4)
    ]
    return Shape(vertices, [*sides, (3, 2, 1, 0), (12, 13, 14, 15)])


def _ring(radius: float, thickness: float, around: int = 64, across: int = 32) -> Shape:
    """Return a torus; of ``radius`` 0 a ball."""
    vertices = []
    for u in (2 * math.pi * i / around for i in range(around)):
        for v in (2 * math.pi * j / across for j in range(across)):
            reach = radius + thickness * math.cos(v)
            vertices.append((reach * math.cos(u), reach * math.sin(u), thickness * math.sin(v)))
    return Shape(vertices, _quads(around, across))


def _ball(radius: float, around: int = 96, across: int = 48) -> Shape:
    """Return a ball from pole to pole."""
    places = [
        (2 * math.pi * i / around, math.pi * (j / (across - 1) - 0.5)) for i in range(around) for j in range(across)
    ]
    vertices = [
        (radius * math.cos(v) * math.cos(u), radius * math.cos(v) * math.sin(u), radius * math.sin(v))
        for u, v in places
    ]
    return Shape(vertices, [face for face in _quads(around, across) if face[1] % across])


def _quads(around: int, across: int) -> list[tuple[int, ...]]:
    """Return the faces of a net that is closed both ways, vertex i * across + j."""
    return [
        (i * across + j, i * across + (j + 1) % across, k * across + (j + 1) % across, k * across + j)
        for i in range(around)
        for j in range(across)
        for k in [(i + 1) % around]
    ]


def _sheet(angles: Sequence[float]) -> Shape:
    """Return an upright sheet that is bent at each angle, in degrees, to and fro."""
    x, y, heading = 0.0, 0.0, 0.35
    vertices = [(x, y, 0.0), (x, y, 1.7)]
    for angle, way in zip((*angles, 0), (-1, 1) * len(angles), strict=False):
        x, y = x + 0.6 * math.cos(heading), y + 0.6 * math.sin(heading)
        vertices += [(x, y, 0), (x, y, 1.7)]
        heading += way * math.radians(angle)
    return Shape(vertices, [(2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1) for i in range(len(angles) + 1)])


def main() -> None:
    """Render into a folder."""
    parser = argparse.ArgumentParser(
        prog="python -m tools.blender.passes_shot", description="Render the shot of passes."
    )
    parser.add_argument("folder", type=Path, help="where the frames go, such as tests/data/blender")
    parser.add_argument("--width", type=int, default=WIDTH, help="in pixels (%(default)s)")
    given = parser.parse_args()
    render(make(), given.folder.resolve(), given.width)


if __name__ == "__main__":
    main()
