"""The node that steadies whatever goes through it: a mean over frames, along the motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.choices import FALLOFFS, WINDOW_ENDS
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import SPACE
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.port_types import pixel_type

#: An input on the frames of the window, by their offset from the node's own.
Window = Mapping[int, Image]


def run_motion_window(
    context: Context,
    image: Window,
    motion: Window,
    guide: Window | None,
    depth: Window | None,
    normal: Window | None,
    *,
    reach: int,
    ends: str,
    space: str,
    **window: Any,
) -> dict[str, Image]:
    from flowabs_nodes.filters.motion.convention import lost_pixels  # numba, which no declaration needs
    from flowabs_nodes.filters.motion.window import motion_window
    from flowabs_nodes.filters.motion.window_frames import window_offsets

    own = image[0]
    given = [each for each in (image, motion, guide, depth, normal) if each is not None]
    offsets = window_offsets(given, reach)
    _tell_what_is_missing(context, offsets, reach, ends)
    if not offsets:
        nothing = np.zeros((own.data_window.height, own.data_window.width), np.float32)
        return {"image": own, "confidence": own.with_pixels(nothing, "matte")}
    frames = (0, *offsets)
    lost = lost_pixels(motion[0].pixels)
    if lost:
        context.note(
            f"{lost} pixels have a motion that leads nowhere (NaN, Inf, 1e9 or more): they keep to their frame"
        )
    looks_at = guide or (image if pixel_type(own.type).light else None)
    result = motion_window(
        {k: _values(image[k], space) for k in frames},
        {k: motion[k].pixels for k in frames},
        None if looks_at is None else {k: _lightness(looks_at[k], space) for k in frames},
        None if depth is None else {k: depth[k].pixels[..., 0] for k in frames},
        None if normal is None else {k: normal[k].pixels for k in frames},
        _coverage(image, frames),
        reach=reach,
        **window,
    )
    if result.misfit is not None and result.misfit.wrong:
        context.warn(
            "frames fit worse along the motion than without it: it may be of another convention (y down, forward for "
            "backward); read_motion has a parameter for that"
        )
        context.note(
            f"along the motion the guide differs by {result.misfit.along:.3g} code values from frame to frame, "
            f"without it by {result.misfit.still:.3g}"
        )
    mean = own.with_codes(result.mean, space) if own.type == "color" else own.with_pixels(result.mean)
    return {"image": mean, "confidence": own.with_pixels(result.confidence, "matte")}


def _tell_what_is_missing(context: Context, offsets: tuple[int, ...], reach: int, ends: str) -> None:
    """Raise ArgumentError, or note, where frames of the window are not there."""
    missing = [k for k in range(-reach, reach + 1) if k not in (0, *offsets)]
    if not missing:
        return
    numbers = ", ".join(str(context.frame + k) for k in missing)
    what = f"frame{'s' if len(missing) > 1 else ''} {numbers} of its window"
    if ends == "error":
        raise ArgumentError(
            f"{what} cannot be reached: beyond the ends of the sequence, or behind a hole",
            code="missing-frames",
            hint='ends: "shrink" takes the frames that are there',
            parameter="ends",
        )
    context.note(f"{what} cannot be reached: the window is smaller")


def _values(image: Image, space: str) -> Array:
    """Return what is averaged: code values of a color, in which no highlight outweighs all the rest."""
    if image.type == "color":
        return image.encoded(space)
    return image.pixels if image.type == "flow" else image.pixels[..., 0]


def _lightness(guide: Image, space: str) -> Array:
    """Return the code values of a guide: of a color its lightness, on white; a mono is code values already."""
    return guide.encoded_mono(space, ground=1.0) if guide.type == "color" else guide.pixels[..., 0]


def _coverage(image: Window, frames: tuple[int, ...]) -> dict[int, Array] | None:
    """Return the alpha of each frame; None where all are opaque."""
    alphas = {k: image[k].alpha for k in frames}
    if all(alpha is None for alpha in alphas.values()):
        return None
    opaque = np.ones(image[0].pixels.shape[:2], np.float32)
    return {k: opaque if alpha is None else alpha for k, alpha in alphas.items()}


def _frames(params: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    window = tuple(range(-params["reach"], params["reach"] + 1))
    return dict.fromkeys(("image", "motion", "guide", "depth", "normal"), window)


MOTION_WINDOW = Node(
    type="motion_window",
    version=1,
    label="Steady in motion",
    category="motion",
    help="Steadies a picture: each pixel's mean over the frames around it, along its motion, where they agree.",
    doc=" ".join(
        (
            "Motion is followed from frame to frame, there and back. A frame counts less the more the guide changes",
            "(a shadow, a highlight that moves), and not at all where the pixel's surface is hidden there, out of the",
            "picture, or does not come back to where it started. A pixel's own frame always counts. Each frame is made",
            "from the frames around it and from no earlier result, so that frames can be made in any order.",
            "Put it on the plate, before lines and regions: what they see is steady then, and so are all thresholds.",
            "A color is averaged as code values, which is how those nodes see it: a mean of light would be that of its",
            "brightest frame, and a firefly would last for the whole window. A flow is averaged as tensors.",
            "HDR: code values go on above white, and nothing is clipped. Alpha stays, and colours count by it.",
            "The motion of silhouettes mixes two surfaces: with a depth, the nearest pure pixel's is taken.",
        )
    ),
    inputs=(
        Port("image", "color|mono|matte|flow", "What to steady."),
        Port("motion", "motion", "Where each pixel comes from and goes to: a motion pass, or optical_flow's."),
        Port(
            "guide",
            "color|mono",
            "Says whether frames agree: of a color its lightness, a mono as code values. Without it a color or mono "
            "image is its own guide, and a matte or flow has none.",
            optional=True,
        ),
        Port("depth", "depth", "Depth: a surface that is hidden on a frame does not count there.", optional=True),
        Port("normal", "normal", "Normals: a surface that has turned away does not count.", optional=True),
    ),
    outputs=(
        Port("image", "=image", "The steady picture."),
        Port(
            "confidence",
            "matte",
            "How much of the window counted: 1 all of it, 0 the pixel's own frame alone.",
        ),
    ),
    params=(
        Param.int(
            "reach",
            2,
            min=0,
            max=4,
            soft=(0, 4),
            unit="frames",
            group="Window",
            help="How many frames before and after are averaged. 0 changes nothing; 2 leaves about half of the noise.",
        ),
        Param.enum(
            "falloff",
            "gaussian",
            FALLOFFS,
            group="Window",
            help="How much a frame counts by its distance in time: less the farther away, or all alike.",
        ),
        Param.enum(
            "ends",
            "shrink",
            WINDOW_ENDS,
            in_key=False,  # an error is no picture
            label="At the ends",
            group="Window",
            help="What to do where frames are not there: before the first, after the last, or behind a hole.",
        ),
        Param.float(
            "agreement",
            8.0,
            min=0,
            max=10_000,
            above=True,
            soft=(2, 30),
            unit="code values",
            group="Agreement",
            help="Change of the guide at which a frame counts 0.6: lower keeps moving shadows and highlights crisp, "
            "higher is steadier.",
        ),
        Param.float(
            "guide_blur",
            2.0,
            min=0,
            max=200,
            soft=(0, 6),
            unit="px",
            label="Blur of the guide",
            group="Agreement",
            help="Gaussian blur of the guide, so that noise does not count as change.",
        ),
        Param.float(
            "consistency",
            1.0,
            min=0,
            max=200,
            soft=(0.25, 8),
            unit="px",
            group="Hidden surfaces",
            help="How far from its start a pixel may come back when its motion is followed to the next frame and back.",
        ),
        Param.float(
            "depth_tolerance",
            0.05,
            min=0,
            max=1000,
            soft=(0.01, 0.2),
            unit="of the depth per frame",
            group="Hidden surfaces",
            help="How much the depth may change from frame to frame: 0.05 is 5 %. Needs the depth.",
        ),
        Param.float(
            "normal_tolerance",
            26.0,
            min=0,
            max=180,
            soft=(5, 90),
            unit="degrees",
            group="Hidden surfaces",
            help="How far the normal may turn within the window. Needs the normals.",
        ),
        SPACE,
    ),
    run=run_motion_window,
    frames=_frames,
)
