"""Runs a scene's graph on the passes of one frame, and fills the pictures that its compositor reads."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import bpy

from flowabs_nodes import Image, RunnableGraph, Session, load_graph
from flowabs_nodes.engine.data_windows import with_alpha
from flowabs_nodes.errors import FlowabsError

from .. import tree_json
from ..fill_datablock import show
from ..messages import message
from ..plates import with_picture
from . import settings
from .failed_picture import failed_picture


class KeptSession:
    """Keeps what was computed for the next frame, and for the next turn of a knob."""

    def __init__(self) -> None:
        self._session: Session | None = None

    def run(self, graph: RunnableGraph, names: Iterable[str], frame: int) -> dict[str, Image]:
        """Return outputs of a graph on a frame, by their names. Raises FlowabsError."""
        if self._session is None:
            self._session = Session(graph)
        else:
            self._session.exchange(graph)
        return self._session.run(names, frame)

    def close(self) -> None:
        """Let go of all that is kept."""
        if self._session is not None:
            self._session.close()
        self._session = None


KEPT = KeptSession()


def graph_of(tree: bpy.types.NodeTree, passes: str) -> RunnableGraph:
    """Return a tree's graph, which reads the passes in those files. Raises FlowabsError with what is wrong with it."""
    graph, _ = with_picture(load_graph(tree_json.graph_of(tree)), Path(passes))
    return graph


def fill(scene: bpy.types.Scene, frame: int) -> None:
    """Fill a scene's pictures with the results of a frame.

    Where that fails, they are filled with a picture that nobody takes for a result, which says what is wrong; the
    scene's ``problems`` and the console say it too.
    """
    try:
        _fill(scene, frame)
    except FlowabsError as error:
        error.frame = None if error.frame == frame else error.frame  # said first, as the lines begin with it
        _fail(scene, frame, message(error))
    except Exception as error:  # a bug: all the same, no other frame's result may stand for this one's
        _fail(scene, frame, f"{type(error).__name__}: {error}")
        raise


def _fill(scene: bpy.types.Scene, frame: int) -> None:
    results = scene.flowabs_compositing.results
    if scene.flowabs_tree is None:
        raise FlowabsError("the scene's graph is gone", hint="Set Up in the Compositor again")
    for result in results:
        if result.image is None:
            raise FlowabsError(f"the picture of {result.name!r} is gone", hint="Set Up in the Compositor again")
    graph = graph_of(scene.flowabs_tree, settings.passes_file(scene))
    images = KEPT.run(graph, [result.name for result in results], frame)
    for result in results:
        show(with_alpha(images[result.name]), result.image.name)  # outside of a render region there is nothing
    expected = settings.size_of(scene)
    for size in {image.display_window[2:] for image in images.values()} - {expected}:
        said = "the result is of {}x{}, the scene of {}x{}".format(*size, *expected)
        note(scene, f"frame {frame}: {said} (Set Up in the Compositor again brings it to the size of the passes)")


def _fail(scene: bpy.types.Scene, frame: int, said: str) -> None:
    """Say what is wrong, wherever somebody may look."""
    said = f"frame {frame}: {said}"
    note(scene, said)
    picture = failed_picture(*settings.size_of(scene), said)
    for result in scene.flowabs_compositing.results:
        if result.image is not None:
            show(picture, result.image.name)


def note(scene: bpy.types.Scene, said: str) -> None:
    """Add a line to what went wrong in this render, and print it."""
    owned = scene.flowabs_compositing
    owned.problems = "\n".join(filter(None, (owned.problems, said)))
    print(f"flowabs: {scene.name}: {said}", file=sys.stderr, flush=True)
