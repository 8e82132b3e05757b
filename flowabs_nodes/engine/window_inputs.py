"""Hands a node the inputs that it reads on several frames: each as a dict from frame offset to Image."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, cast

from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context, Node
from flowabs_nodes.nodes.frame_offsets import frame_offsets

#: A node's inputs by name: an Image, or of an input that is read on several frames a dict from offset to Image.
NodeInputs = Mapping[str, Image | Mapping[int, Image]]


def own_frame(given: Image | Mapping[int, Image]) -> Image:
    """Return the image of the node's own frame."""
    return given if isinstance(given, Image) else given[0]


def join_windows(declaration: Node, inputs: NodeInputs, params: Mapping[str, Any]) -> tuple[Node, Mapping[str, Image]]:
    """Split the frames around a node's own off its inputs, and return a declaration whose ``run`` joins them again.

    Everything that is done with a node's inputs and outputs can so be done with images of its own frame. When ``run``
    is called, the frames around are brought to the type and the data window of its own frame, 0 where they have no
    pixels. An input that the node reads on several frames may be given as one Image: it is the own frame's.

    Raises
    ------
    FlowabsError
        wrong-frames (:func:`~flowabs_nodes.nodes.frame_offsets.frame_offsets`); missing-input where the own frame is
        missing in a dict; when ``run`` is called, window-mismatch where a frame is of a picture of another size.
    """
    if declaration.frames is None:
        return declaration, cast(Mapping[str, Image], inputs)
    windows = {}
    for name in frame_offsets(declaration, declaration.defaults() | dict(params)).keys() & inputs.keys():
        given = inputs[name]
        windows[name] = {0: given} if isinstance(given, Image) else dict(sorted(given.items()))
        if 0 not in windows[name]:
            found = ", ".join(map(str, windows[name])) or "none"
            raise FlowabsError(
                f"input {name!r} needs the node's own frame, 0, among its frame offsets, found {found}",
                code="missing-input",
            )

    def run(context: Context, **arguments: Any) -> Any:
        for name, window in windows.items():
            own = arguments[name]
            for offset, image in window.items():
                _check_frame_size(name, context.frame, offset, image, own)
            arguments[name] = {
                offset: image.as_type(own.type).on_window(own.data_window) if offset else own
                for offset, image in window.items()
            }
        return declaration.run(context, **arguments)

    own_frames = {name: windows[name][0] if name in windows else cast(Image, inputs[name]) for name in inputs}
    return replace(declaration, run=run), own_frames


def _check_frame_size(name: str, frame: int, offset: int, image: Image, own: Image) -> None:
    """Raise FlowabsError where the frame at ``offset`` is of a picture of another size than the node's own frame."""
    found, wanted = image.display_window, own.display_window
    if (found.width, found.height) != (wanted.width, wanted.height):
        raise FlowabsError(
            f"frame {frame + offset} of input {name!r} is of a picture of {found.width}x{found.height}, "
            f"but frame {frame} of {wanted.width}x{wanted.height}",
            code="window-mismatch",
            hint="all frames of a shot have one display window",
        )
