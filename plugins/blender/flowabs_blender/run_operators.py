"""Operators that run a graph: on a picture, on the last render with its passes, on rendered frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.io_utils import ExportHelper

from flowabs_nodes import Image, Report
from flowabs_nodes.errors import CommandError

from . import fill_datablock, image_editors, sequence_paths
from .background import Background
from .background_operator import InBackground
from .knobs import is_ours
from .messages import message
from .node_operators import shown_tree
from .picture_run import PictureRun
from .read_datablock import take
from .render_result import take_last_render
from .sequence_run import SequenceRun
from .taken import Taken
from .tree_json import graph_of

MOST_FAILURES = 3  # that are reported each


class RunsGraph(InBackground):
    """Runs the graph that is shown, or the scene's; mixed into operators."""

    tree: bpy.props.StringProperty(description="Name of the graph; empty: the one shown", options={"HIDDEN"})
    output: bpy.props.StringProperty(
        name="Output", description="The output to compute; empty: the one chosen in the sidebar"
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Return whether there is any graph."""
        return any(map(is_ours, bpy.data.node_groups))

    def chosen_tree(self, context: bpy.types.Context) -> bpy.types.NodeTree:
        """Return the graph to run. Raises CommandError where there is none."""
        tree = bpy.data.node_groups.get(self.tree) if self.tree else shown_tree(context)
        if not is_ours(tree):
            what = f"there is no flowabs graph {self.tree!r}" if self.tree else "no flowabs graph is shown here"
            raise CommandError(
                what, code="unknown-graph", hint="" if self.tree else "Use in this scene makes one its own"
            )
        self._name = tree.name
        return tree

    def chosen_output(self, tree: bpy.types.NodeTree) -> str:
        """Return the output that is chosen; "" for all that the graph writes."""
        return self.output or tree.run_settings.output


class RunsOnPicture(RunsGraph):
    """Runs a graph on one picture; mixed into operators."""

    file: bpy.props.StringProperty(name="File", description="An EXR to write; empty: none", subtype="FILE_PATH")

    def on_picture(
        self, context: bpy.types.Context, tree: bpy.types.NodeTree, picture: Taken, scale: float = 1.0
    ) -> PictureRun:
        """Return the work on a picture."""
        output = self.chosen_output(tree)
        self._made_of = picture.name
        return PictureRun(
            graph=graph_of(tree),
            picture=picture,
            outputs=(output,) if output else (),
            frame=context.scene.frame_current,
            scale=scale,
            file=Path(bpy.path.abspath(self.file)) if self.file else None,
        )

    def finish(self, context: bpy.types.Context, made: dict[str, Image]) -> None:
        """Put images into datablocks, and the first one into the Image Editor."""
        shown = [fill_datablock.show(image, f"{self._name} {output}", self._made_of) for output, image in made.items()]
        image_editors.show(context, shown[0], bpy.data.images.get(self._made_of))
        self.report({"INFO"}, f"made {', '.join(each.name for each in shown)}")


class FLOWABS_OT_run(RunsOnPicture, bpy.types.Operator):
    """Run the graph on a picture"""

    bl_idname = "flowabs.run"
    bl_label = "Run on this picture"

    image: bpy.props.StringProperty(
        name="Picture", description="The Image to run on; empty: the one in the Image Editor, or chosen in the sidebar"
    )
    scale: bpy.props.FloatProperty(name="Scale", description="A smaller picture", default=1, min=0.01, max=1)

    def prepare(self, context: bpy.types.Context) -> Callable[[Background[Any]], Any]:
        """Take the picture and the graph as they are now."""
        tree = self.chosen_tree(context)
        datablock, user = self._chosen_picture(context, tree)
        return self.on_picture(context, tree, take(datablock, user=user), self.scale)

    def _chosen_picture(
        self, context: bpy.types.Context, tree: bpy.types.NodeTree
    ) -> tuple[bpy.types.Image, bpy.types.ImageUser | None]:
        """Return the picture to run on, of a result that which it was made of, and how an editor shows it."""
        space = context.space_data
        user = None
        if self.image:
            datablock = bpy.data.images.get(self.image)
            if datablock is None:
                raise CommandError(f"there is no image {self.image!r}", code="unknown-image")
        elif space is not None and space.type == "IMAGE_EDITOR" and space.image is not None:
            datablock, user = space.image, space.image_user
        else:
            datablock = tree.run_settings.image
        plate = fill_datablock.plate_of(datablock) if datablock is not None else None
        if plate is None:
            raise CommandError("no picture is chosen", code="no-image", hint="open one, or choose it in the sidebar")
        return plate, user if plate == datablock else None


class FLOWABS_OT_run_to_file(RunsGraph, bpy.types.Operator, ExportHelper):
    """Run the graph on a picture, and write the result to an EXR too"""

    bl_idname = "flowabs.run_to_file"
    bl_label = "Run to EXR"

    filename_ext = ".exr"
    filter_glob: bpy.props.StringProperty(default="*.exr", options={"HIDDEN"})
    image: bpy.props.StringProperty(options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for the file."""
        return ExportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Run, in the background where there is a window."""
        return bpy.ops.flowabs.run(
            "INVOKE_DEFAULT", tree=self.tree, output=self.output, image=self.image, file=self.filepath
        )


class FLOWABS_OT_run_on_render(RunsOnPicture, bpy.types.Operator):
    """Run the graph on the last render: nodes that read passes, and have no file, read those of the render"""

    bl_idname = "flowabs.run_on_render"
    bl_label = "Run on last render"

    def prepare(self, context: bpy.types.Context) -> Callable[[Background[Any]], Any]:
        """Save the render, and take the graph as it is now."""
        tree = self.chosen_tree(context)
        return self.on_picture(context, tree, take_last_render(context.scene))


class FLOWABS_OT_run_sequence(RunsGraph, bpy.types.Operator):
    """Run the graph on rendered frames, in the background; frames that are there and whole are kept"""

    bl_idname = "flowabs.run_sequence"
    bl_label = "Run on frames"

    frames_in: bpy.props.StringProperty(name="Frames", description="Such as shot.####.exr; empty: as in the sidebar")
    frames_out: bpy.props.StringProperty(name="Results", description="Such as a.####.exr; empty: as in the sidebar")
    frame_range: bpy.props.StringProperty(name="Range", description="Such as 1-100x2; empty: as in the sidebar")

    def prepare(self, context: bpy.types.Context) -> Callable[[Background[Any]], Any]:
        """Take the graph as it is now, and find out where the frames are."""
        tree = self.chosen_tree(context)
        said = tree.run_settings
        given = self.frames_in or said.frames_in
        frames = bpy.path.abspath(given) if given else sequence_paths.rendered(context.scene)
        results = self.frames_out or said.frames_out
        return SequenceRun(
            graph=graph_of(tree),
            input=frames,
            output=bpy.path.abspath(results) if results else sequence_paths.beside(frames, tree.name),
            frames=self.frame_range or said.frame_range or sequence_paths.scene_range(context.scene),
            chosen=self.chosen_output(tree),
            existing=said.existing,
        )

    def finish(self, context: bpy.types.Context, made: Report) -> None:
        """Say what became of the frames, and show those that are there as a sequence."""
        failed = [frame for frame in made.frames if frame.error is not None]
        for frame in failed[:MOST_FAILURES]:
            self.report({"ERROR"}, message(frame.error))
        counts = ", ".join(f"{count} {status}" for status, count in made.counts.items() if count)
        self.report({"WARNING" if failed else "INFO"}, f"{self._name}: {counts}")
        files = [frame.files[0] for frame in made.frames if frame.error is None and frame.files]
        if files:
            datablock = bpy.data.images.load(files[0], check_existing=True)
            datablock.source = "SEQUENCE"
            space = image_editors.show(context, datablock)
            if space is not None:
                user, numbers = space.image_user, [frame.frame for frame in made.frames]
                user.frame_start = min(numbers)
                user.frame_offset = min(numbers) - 1
                user.frame_duration = max(numbers) - min(numbers) + 1
                user.use_auto_refresh = True


CLASSES = (FLOWABS_OT_run, FLOWABS_OT_run_to_file, FLOWABS_OT_run_on_render, FLOWABS_OT_run_sequence)
