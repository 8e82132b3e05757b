"""Shows a graph's result while its sliders move: looks for changes on a timer, has them computed, shows the newest.

Blender calls nothing of ours when a knob moves, and only its main thread may touch its data.
"""

from __future__ import annotations

import time
from typing import Any

import bpy

from flowabs_nodes.errors import FlowabsError

from . import fill_datablock, image_editors, knob_watch, tree_changes
from .color_names import working_space
from .knobs import is_ours
from .messages import message
from .preview_worker import PreviewWorker, Shown, Wish
from .read_datablock import take
from .taken import Taken
from .tree_json import graph_of

QUICK, SLOW = 0.01, 0.1  # seconds between two looks while something happens, and while nothing does
RESTING = 2.0  # seconds without a change after which nothing happens

#: The previews that are on, by the name of their tree.
_previews: dict[str, Preview] = {}


class Preview:
    """Keeps a datablock, "<tree> preview", at what a tree makes of its picture.

    Attributes
    ----------
    problem
        Why there is no new result; "" where there is one.
    seconds
        What the newest result took to compute.
    """

    def __init__(self) -> None:
        self.problem = ""
        self.seconds = 0.0
        self.moved = time.monotonic()
        self._worker = PreviewWorker(working_space())
        self._is_shown = False
        self._asked: Any = None
        self._taken: tuple[Any, Taken] | None = None

    @property
    def settled(self) -> bool:
        """Return whether all that was asked for is shown."""
        return not self._worker.busy

    @property
    def resting(self) -> bool:
        """Return whether nothing has happened for a while."""
        return self.settled and time.monotonic() - self.moved > RESTING

    def look(self, tree: bpy.types.NodeTree) -> None:
        """Show what was made since the last look, and ask for what has changed since. For the main thread alone."""
        shown = self._worker.take()
        if shown is not None:
            self.problem = message(shown.error) if shown.error is not None else ""
            self.seconds = shown.seconds
            if shown.pixels is not None:
                self._show(tree, shown)
        state = _state(tree)
        if state == self._asked:
            return
        self._asked, self.moved = state, time.monotonic()
        try:
            self._worker.ask(self._wish(tree))
        except FlowabsError as error:
            self.problem = message(error)

    def _show(self, tree: bpy.types.NodeTree, shown: Shown) -> None:
        """Fill the datablock; the first time it takes the place of the picture in the Image Editors."""
        plate = tree.run_settings.image
        made_of = plate.name if plate is not None else ""
        datablock = fill_datablock.show_pixels(shown.pixels, shown.are_colors, preview_name(tree), made_of)
        if not self._is_shown:
            if not image_editors.exchange(plate, datablock):
                image_editors.show(bpy.context, datablock)
            self._is_shown = True
        image_editors.refresh(datablock)

    def close(self) -> None:
        """Let go of everything."""
        self._worker.close()

    def _wish(self, tree: bpy.types.NodeTree) -> Wish:
        said = tree.run_settings
        return Wish(
            graph=graph_of(tree),
            picture=self._picture(said.image),
            output=said.output,
            frame=bpy.context.scene.frame_current,
            scale=float(said.scale),
        )

    def _picture(self, datablock: bpy.types.Image | None) -> Taken:
        """Return the tree's picture, taken anew where it has changed."""
        if datablock is None:
            raise FlowabsError("no picture is chosen", code="no-image")
        state = _picture_state(datablock)
        if self._taken is None or self._taken[0] != state:
            self._taken = (state, take(datablock))
        return self._taken[1]


def preview_name(tree: bpy.types.NodeTree) -> str:
    """Return the name of the datablock that shows a tree's preview."""
    return f"{tree.name} preview"


def _state(tree: bpy.types.NodeTree) -> Any:
    """Return what a preview depends on, cheaply."""
    said = tree.run_settings
    picture = None if said.image is None else _picture_state(said.image)
    frame = bpy.context.scene.frame_current
    return tree_changes.count(tree), knob_watch.positions(tree), picture, said.output, said.scale, frame


def _picture_state(datablock: bpy.types.Image) -> Any:
    """Return what tells that a picture is another one; painting on it does not."""
    said = datablock.colorspace_settings.name
    frame = bpy.context.scene.frame_current if datablock.source == "SEQUENCE" else 0
    return datablock.name, datablock.filepath, datablock.source, datablock.is_dirty, said, datablock.alpha_mode, frame


# ---------------------------------------------------------------------- which previews are on


def preview_of(tree: bpy.types.NodeTree) -> Preview | None:
    """Return the preview of a tree; None where it is off."""
    return _previews.get(tree.name)


def switch(tree: bpy.types.NodeTree, *, on: bool) -> None:
    """Switch the preview of a tree on or off."""
    if not on:
        preview = _previews.pop(tree.name, None)
        if preview is not None:
            preview.close()
            image_editors.exchange(bpy.data.images.get(preview_name(tree)), tree.run_settings.image)
    elif tree.name not in _previews:
        _previews[tree.name] = Preview()
        if not bpy.app.timers.is_registered(tick):
            bpy.app.timers.register(tick, first_interval=QUICK)


def tick() -> float | None:
    """Have each preview look after its tree; return the seconds until the next time, None where none is on."""
    for name in list(_previews):
        tree = bpy.data.node_groups.get(name)
        if is_ours(tree):
            _previews[name].look(tree)
        else:  # renamed, or removed
            _previews.pop(name).close()
    if not _previews:
        return None
    return SLOW if all(preview.resting for preview in _previews.values()) else QUICK


def close_all() -> None:
    """Switch all previews off, and the timer."""
    while _previews:
        _previews.popitem()[1].close()
    if bpy.app.timers.is_registered(tick):
        bpy.app.timers.unregister(tick)
