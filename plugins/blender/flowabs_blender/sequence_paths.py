"""Says by which names Blender's rendered frames lie on disk, and by which the frames that a graph makes of them."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

from flowabs_nodes.errors import CommandError


def rendered(scene: bpy.types.Scene) -> str:
    """Return the pattern of the frames that a scene renders, such as ``/shots/a_####.exr``.

    Raises CommandError where the folder depends on a .blend that was never saved, or frames go to a movie.
    """
    if scene.render.filepath.startswith("//") and not bpy.data.filepath:
        raise CommandError(
            f"the scene's render output is {scene.render.filepath}, beside a .blend that is not saved yet",
            code="bad-path",
            hint="save the .blend, or name the frames",
        )
    if scene.render.is_movie_format:
        raise CommandError("the scene renders to a movie", code="no-frames", hint="render OpenEXR frames")
    zero, one = (scene.render.frame_path(frame=number) for number in (0, 1))
    last = next((place for place, (a, b) in enumerate(zip(zero, one, strict=True)) if a != b), None)
    if last is None:
        return os.path.abspath(zero)
    width = next(digits for digits in range(1, 20) if len(scene.render.frame_path(frame=10**digits)) > len(zero))
    return os.path.abspath(zero[: last + 1 - width] + "#" * width + zero[last + 1 :])


def beside(pattern: str, name: str) -> str:
    """Return where a graph's frames go by default: to a folder of its name beside the rendered ones."""
    folder = (
        "".join(letter if letter.isalnum() or letter in "-_. " else "_" for letter in name).strip(". ") or "flowabs"
    )
    return str(Path(pattern).parent / folder / f"{folder}.####.exr")


def scene_range(scene: bpy.types.Scene) -> str:
    """Return a scene's frames as a range: "1-250", or "1-250x2"."""
    step = f"x{scene.frame_step}" if scene.frame_step > 1 else ""
    return f"{scene.frame_start}-{scene.frame_end}{step}"
