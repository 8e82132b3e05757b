"""Holds what a graph is run on, and how; each tree has its own."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from flowabs_nodes.choices import readable
from flowabs_nodes.file_choices import EXISTING

from .fill_datablock import MARK
from .identifiers import graph_nodes
from .properties import RELATIVE_PATHS
from .tree_json import names_of

SCALES = (("1", "Full size", ""), ("0.5", "Half", ""), ("0.25", "Quarter", ""))

_MEANINGS = {
    "resume": "Keep frames that are whole and made of the same graph and plate",
    "overwrite": "Make all frames again",
    "error": "Fail on a file that is there",
}


def outputs_of(tree: bpy.types.NodeTree) -> Iterator[str]:
    """Yield the name of each output of a tree: that of its node, and of an output that is not the first one too."""
    names = names_of(tree)
    for node in graph_nodes(tree):
        for number, socket in enumerate(node.outputs):
            yield f"{names[node.name]}.{socket.port}" if number else names[node.name]


def _found(self: Any, context: bpy.types.Context, text: str) -> list[str]:
    return [name for name in outputs_of(self.id_data) if text.lower() in name.lower()]


def _is_plate(self: Any, image: bpy.types.Image) -> bool:
    return MARK not in image


_EXISTING = tuple((word, readable(word), _MEANINGS[word]) for word in EXISTING)


class FlowabsRunSettings(bpy.types.PropertyGroup):
    """What the graph runs on"""

    image: bpy.props.PointerProperty(
        type=bpy.types.Image, poll=_is_plate, name="Picture", description="What the graph's plate is in Blender"
    )
    output: bpy.props.StringProperty(
        name="Output",
        description="The output to compute, such as lines or lines.response; empty: the image that is written",
        search=_found,
    )
    scale: bpy.props.EnumProperty(
        name="Size", description="Size of the preview; lengths follow", items=SCALES, default="0.5"
    )
    frames_in: bpy.props.StringProperty(
        name="Frames",
        description="The rendered frames: shot.####.exr; empty: where the scene renders to",
        subtype="FILE_PATH",
        options=RELATIVE_PATHS,
    )
    frames_out: bpy.props.StringProperty(
        name="Results",
        description="The frames to write: lines.####.exr; empty: a folder with the graph's name beside the frames",
        subtype="FILE_PATH",
        options=RELATIVE_PATHS,
    )
    frame_range: bpy.props.StringProperty(
        name="Range", description="Which frames: 1-100x2,200; empty: those of the scene"
    )
    existing: bpy.props.EnumProperty(
        name="Existing",
        description="What happens to results that are there",
        items=_EXISTING,
        default="resume",
    )
