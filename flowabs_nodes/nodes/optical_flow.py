"""The node that finds the motion of a plate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.choices import FLOW_PRESETS
from flowabs_nodes.filters.opencv import MOTION_EXTRA
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import GROUND, SPACE
from flowabs_nodes.nodes.declare import Context, Node, Param, Port


def run_optical_flow(
    context: Context, image: Mapping[int, Image], *, ground: float, space: str, **optical_flow: Any
) -> Image:
    code = {k: frame.encoded_mono(space, ground=ground) for k, frame in image.items()}
    motion = filters.optical_flow(code[0], code.get(-1), code.get(1), **optical_flow)
    return image[0].with_pixels(motion, "motion")


def _frames(params: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    return {"image": (-1, 0, 1)}


OPTICAL_FLOW = Node(
    type="optical_flow",
    version=1,
    label="Optical flow",
    category="motion",
    help="Finds the motion of a plate that has no motion pass, from each frame to its neighbours.",
    doc=(
        "OpenCV's DIS (Kroeger et al. 2016), on lightness in 8 bits: what is above white is clipped. A renderer's own "
        "motion pass is better, wherever there is one: DIS guesses where surfaces are flat, noisy or hidden. "
        "motion_window compares the way there with the way back, and leaves such pixels alone. On the first frame the "
        "way to the one before is 0, on the last one the way to the next; motion_window never looks there."
    ),
    inputs=(Port("image", "color", "The plate; its frames before and after are read too."),),
    outputs=(Port("motion", "motion", "Where each pixel comes from and goes to, as a motion pass."),),
    params=(
        Param.enum("preset", "medium", FLOW_PRESETS, help="How fine it looks: medium is the finest and the slowest."),
        Param.float(
            "pre_blur",
            1.0,
            min=0,
            max=200,
            soft=(0, 4),
            unit="px",
            label="Blur before",
            help="Gaussian blur of the plate before: against noise, which else looks like motion.",
        ),
        GROUND,
        SPACE,
    ),
    run=run_optical_flow,
    frames=_frames,
    packages={"cv2": MOTION_EXTRA},
)
