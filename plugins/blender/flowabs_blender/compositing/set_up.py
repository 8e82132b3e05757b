"""Sets a scene up for compositing with flowabs, and takes that away again."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from flowabs_nodes import Image
from flowabs_nodes.engine.plan import named_result, output_names
from flowabs_nodes.errors import FlowabsError

from ..fill_datablock import show
from ..knobs import is_ours
from ..outputs import main_outputs
from . import compositor, passes_output
from .frame import graph_of
from .needed_passes import switch_on
from .settings import second_of, size_of

#: What the second scene takes from the first, beside the size.
_OF_THE_SHOT = ("frame_start", "frame_end", "frame_step")
_OF_THE_RENDER = ("pixel_aspect_x", "pixel_aspect_y", "fps", "fps_base")
#: How the second scene composites: without loss, and where there is no display, too.
_EXACT = {"compositor_device": "CPU", "compositor_precision": "FULL"}


def set_up_compositing(
    scene: bpy.types.Scene,
    tree: bpy.types.NodeTree | None = None,
    *,
    folder: str = "",
    outputs: str | Iterable[str] | None = None,
) -> bpy.types.Scene:
    """Have a scene render its passes to EXR files, and a second scene composite what a graph makes of them.

    Render the animation of the first, then that of the second. Where the second scene is there already it is brought
    up to date: size, frames, graph and pictures; its compositor's other nodes and its output stay as they are.

    Parameters
    ----------
    scene
        The scene of the shot, or the second one.
    tree
        The graph; None: the scene's own. Its nodes that read and have no file read the passes.
    folder
        Where the files go; "//" is the folder of the .blend. "": where they went before, at first "//flowabs/".
    outputs
        The graph's outputs to composite, "node" or "node.output"; None: the pictures that it writes.

    Returns
    -------
    bpy.types.Scene
        The second scene.

    Raises
    ------
    FlowabsError
        There is no graph, something is wrong with it, it reads no picture, or the .blend that the folder belongs to is
        not saved yet. Nothing is changed then.
    """
    scene = scene.flowabs_compositing.source or scene
    tree = tree or scene.flowabs_tree
    if not is_ours(tree):
        raise FlowabsError(
            f"the scene {scene.name!r} has no flowabs graph", hint="make one in the node editor, then Use in This Scene"
        )
    second = second_of(scene)
    passes = second.flowabs_compositing.passes if second is not None and not folder else _passes(scene, folder)
    file = bpy.path.abspath(passes)
    graph = graph_of(tree, file)
    names = main_outputs(graph) if outputs is None else output_names(graph, outputs)
    for name in names:
        named_result(graph, name, 1)

    second = second or _new_scene(scene, passes)
    settings = second.flowabs_compositing
    settings.source, settings.passes = scene, passes
    second.flowabs_tree = tree
    scene.flowabs_tree = scene.flowabs_tree or tree
    _follow(second, scene)
    passes_output.send(scene, passes, switch_on(scene, graph, file))
    _have_results(second, names)
    compositor.show_pictures(second, {each.name: each.image for each in settings.results})
    return second


def remove_compositing(scene: bpy.types.Scene) -> None:
    """Remove the second scene, its pictures and its compositor; the first renders to where it did before.

    ``scene`` is either of the two. Raises FlowabsError where nothing was set up, or no other scene is left.
    """
    first = scene.flowabs_compositing.source or scene
    second = second_of(scene)
    if second is None:
        raise FlowabsError(f"the scene {scene.name!r} is not set up for compositing with flowabs")
    if first != second:
        passes_output.take_back(first)
    elif len(bpy.data.scenes) == 1:
        raise FlowabsError(f"the scene {second.name!r} is the only one left")
    pictures = [each.image for each in second.flowabs_compositing.results if each.image is not None]
    trees = compositor.own_trees(second)
    for window in bpy.context.window_manager.windows:
        if window.scene == second:
            window.scene = first if first != second else next(each for each in bpy.data.scenes if each != second)
    bpy.data.scenes.remove(second)
    for owned, collection in ((trees, bpy.data.node_groups), (pictures, bpy.data.images)):
        for each in owned:
            if not each.users:
                collection.remove(each)


def _passes(first: bpy.types.Scene, folder: str) -> str:
    """Return the files of the passes in a folder. Raises FlowabsError where it is beside a .blend that is not saved."""
    folder = folder or "//flowabs/"
    if folder.startswith("//") and not bpy.data.filepath:
        raise FlowabsError(f"{folder} is beside the .blend, which is not saved yet", hint="save it, or name a folder")
    return f"{folder.rstrip('/')}/{bpy.path.clean_name(first.name)}_passes_####.exr"


def _new_scene(first: bpy.types.Scene, passes: str) -> bpy.types.Scene:
    """Return a scene that renders nothing: its output is of the kind of the first one's, and looks the same."""
    second = bpy.data.scenes.new(f"{first.name} flowabs")
    passes_output.copy_kind(first, second)
    second.render.filepath = passes.replace("_passes_####.exr", "_flowabs_####")
    second.render.use_lock_interface = True  # the handler works beside the interface's thread
    passes_output.set_known(second.render, _EXACT)
    return second


def _follow(second: bpy.types.Scene, first: bpy.types.Scene) -> None:
    """Give the second scene the size and the frames of the first."""
    for name in _OF_THE_SHOT:
        setattr(second, name, getattr(first, name))
    for name in _OF_THE_RENDER:
        setattr(second.render, name, getattr(first.render, name))
    second.render.resolution_x, second.render.resolution_y = size_of(first)
    second.render.resolution_percentage = 100
    second.frame_set(first.frame_current)


def _have_results(second: bpy.types.Scene, names: Iterable[str]) -> None:
    """Have a picture for each output, empty until its first frame; those of the same name stay, and all others go.

    A node of the compositor that still reads one of those has none then: better than what nobody fills any more.
    """
    width, height = size_of(second)
    held = {each.name: each.image for each in second.flowabs_compositing.results if each.image is not None}
    second.flowabs_compositing.results.clear()
    for name in held.keys() - set(names):
        bpy.data.images.remove(held[name])
    for name in names:
        result = second.flowabs_compositing.results.add()
        result.name = name
        empty = Image.from_array(np.zeros((height, width, 4), np.float32), encoding="linear", alpha="premultiplied")
        result.image = held[name] if name in held else show(empty, f"{name} of {second.name}")
