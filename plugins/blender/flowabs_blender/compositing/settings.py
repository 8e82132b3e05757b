"""What a scene knows of compositing with flowabs; saved with the scene, in the .blend."""

from __future__ import annotations

import bpy


class FlowabsResult(bpy.types.PropertyGroup):
    """A picture that the compositor reads; ``name`` is the graph's output"""

    image: bpy.props.PointerProperty(type=bpy.types.Image)


class FlowabsCompositing(bpy.types.PropertyGroup):
    """How a scene composites flowabs results; of the scene that renders the passes only ``before`` is set"""

    source: bpy.props.PointerProperty(
        type=bpy.types.Scene, name="Passes of", description="The scene that renders the passes"
    )
    passes: bpy.props.StringProperty(
        name="Passes",
        description="OpenEXR files of the rendered passes; #### stands for the number of the frame",
        subtype="FILE_PATH",
    )
    results: bpy.props.CollectionProperty(type=FlowabsResult)
    problems: bpy.props.StringProperty(description="What went wrong in the last render: a line a frame")
    before: bpy.props.StringProperty(description="The render output that the passes took the place of, JSON")


CLASSES = (FlowabsResult, FlowabsCompositing)


def register() -> None:
    """Give every scene these settings."""
    bpy.types.Scene.flowabs_compositing = bpy.props.PointerProperty(type=FlowabsCompositing)


def unregister() -> None:
    """Take them away; what is saved stays in the file."""
    del bpy.types.Scene.flowabs_compositing


def composites(scene: bpy.types.Scene) -> bool:
    """Return whether a scene's compositor shows flowabs results."""
    return len(scene.flowabs_compositing.results) > 0


def renders_passes(scene: bpy.types.Scene) -> bool:
    """Return whether a scene renders passes for another one."""
    return bool(scene.flowabs_compositing.before)


def first_of(scene: bpy.types.Scene) -> bpy.types.Scene | None:
    """Return the scene that renders the passes, be it this one or the other of the two; None where there is none."""
    return scene.flowabs_compositing.source or (scene if renders_passes(scene) else None)


def second_of(scene: bpy.types.Scene) -> bpy.types.Scene | None:
    """Return the scene that composites, be it this one or the other of the two; None where there is none."""
    if composites(scene):
        return scene
    return next((each for each in bpy.data.scenes if each.flowabs_compositing.source == scene), None)


def size_of(scene: bpy.types.Scene) -> tuple[int, int]:
    """Return the width and height of a scene's render, without its region."""
    render = scene.render
    scale = render.resolution_percentage / 100
    return max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale))


def passes_file(scene: bpy.types.Scene) -> str:
    """Return the files of the passes that a scene composites, with #### for the number of the frame."""
    return bpy.path.abspath(scene.flowabs_compositing.passes, library=scene.library)
