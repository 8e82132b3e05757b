"""Nodes that the paper compares its own with: bilateral filters, mean shift and Canny's edges."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flowabs_nodes import filters
from flowabs_nodes.choices import BILATERAL_KERNELS, ORIENTED_KERNELS
from flowabs_nodes.filters import halo
from flowabs_nodes.filters.opencv import EXTRA
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.common_params import GROUND, SPACE
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from flowabs_nodes.nodes.lines import IMAGE, INK_MASK, LINES, within_mask
from flowabs_nodes.nodes.regions import within
from flowabs_nodes.nodes.smooth import FBL

#: Of the nodes that call OpenCV.
OPENCV = {"cv2": EXTRA}

SMOOTH = Port("image", "color", "The picture to smooth.")
SMOOTHED = Port("image", "color", "The smoothed picture.")


def run_bilateral(context: Context, image: Image, *, space: str, **bilateral: Any) -> Image:
    return image.with_codes(filters.bilateral(image.encoded(space), alpha=image.alpha, **bilateral), space)


def _bilateral_halo(params: Mapping[str, Any]) -> int:
    return halo.bilateral(params["sigma_d"], params["iterations"])


BILATERAL = Node(
    type="bilateral",
    version=1,
    label="Bilateral",
    category="compare",
    help="Bilateral filter: flattens regions between edges, and follows no flow. What FBL is compared with.",
    doc=(
        "Tomasi and Manduchi's [33], each neighbour weighted by its distance and by its difference of colour. HDR: "
        "code values go on above white and nothing is clipped; in lab differences of light above white count by their "
        "cube root, in acescct every stop counts the same."
    ),
    inputs=(SMOOTH,),
    outputs=(SMOOTHED,),
    params=(
        Param.float(
            "sigma_d",
            2.0,
            min=0,
            max=200,
            soft=(0, 5),
            unit="px",
            label="Sigma",
            help="Gaussian of the distance; 0 changes nothing. The time of kernel full grows with its square.",
        ),
        Param.float(
            "sigma_r",
            10.0,
            min=0,
            max=1e6,
            above=True,
            soft=(1, 100),
            unit="code values",
            label="Colour range",
            help="Difference of colour that still counts as alike: higher loses more edges.",
        ),
        Param.int("iterations", 3, min=0, max=100, soft=(1, 10), help="How many times the filter runs."),
        Param.enum(
            "kernel",
            "full",
            BILATERAL_KERNELS,
            help="All neighbours in a square, or those along x, then y (Pham and van Vliet: fast, axis-aligned).",
        ),
        SPACE,
    ),
    run=run_bilateral,
    region=within(_bilateral_halo, "image"),
)


def run_bilateral_oriented(context: Context, image: Image, flow: Image, *, space: str, **oriented: Any) -> Image:
    codes = filters.bilateral_oriented(image.encoded(space), flow.pixels, alpha=image.alpha, **oriented)
    return image.with_codes(codes, space)


def _oriented_halo(params: Mapping[str, Any]) -> int:
    return halo.bilateral_oriented(params["sigma_e"], params["sigma_g"], params["iterations"], params["kernel"])


BILATERAL_ORIENTED = Node(
    type="bilateral_oriented",
    version=1,
    label="Oriented bilateral",
    category="compare",
    help="Bilateral filter along a straight line or an arc that touches the flow, where FBL follows its curve.",
    doc=(
        "Fig. 20 d and e: fbl with its curve replaced. line: the tangent, an anisotropic bilateral filter. arc: the "
        "parabola x + s t + (kappa s^2 / 2) n, kappa the flow's curvature, as in Pham's structure-adaptive bilateral "
        "filter. HDR: as fbl, code values go on above white and nothing is clipped."
    ),
    inputs=FBL.inputs,
    outputs=FBL.outputs,
    params=(
        *(param for param in FBL.params if param.name not in ("sampling", "working_scale", "space")),
        Param.enum("kernel", "line", ORIENTED_KERNELS, help="A straight line, or an arc bent like the flow."),
        *(param for param in FBL.params if param.name in ("sampling", "space")),
    ),
    run=run_bilateral_oriented,
    region=within(_oriented_halo, "image", "flow"),
)


def run_mean_shift(context: Context, image: Image, **mean_shift: Any) -> Image:
    codes = image.encoded("lab")
    clipped = filters.measure_clipping(codes)
    if clipped:
        context.note(f"mean_shift sees 8 bits: {clipped} pixels above white, below black or too saturated were clipped")
    return image.with_codes(filters.mean_shift(codes, alpha=image.alpha, **mean_shift), "lab")


MEAN_SHIFT = Node(
    type="mean_shift",
    version=1,
    label="Mean shift",
    category="compare",
    help="Mean-shift segmentation: flat regions of like colour. What FBL is compared with.",
    doc=(
        "What the paper compares FBL with in Fig. 21. OpenCV's mean shift on 8-bit Lab; then connected regions of like "
        "colour join a neighbour where they are small, and each becomes flat. HDR: what is above white or below black "
        "is clipped, and the log says how many pixels were. Pixels whose A is above 0 count alike, whatever it is."
    ),
    inputs=(SMOOTH,),
    outputs=(Port("image", "color", "The segmented picture."),),
    params=(
        Param.float(
            "spatial",
            10.0,
            min=0,
            max=200,
            soft=(1, 30),
            unit="px",
            label="Radius",
            help="Radius in which a cluster is sought, h_s; rounded. The time grows with its square.",
        ),
        Param.float(
            "range",
            5.0,
            min=0,
            max=255,
            soft=(1, 30),
            unit="8-bit Lab",
            label="Colour range",
            help="Radius in colour, h_r, in OpenCV's 8-bit Lab (L* x 2.55, a*, b*): higher gives fewer colours.",
        ),
        Param.int(
            "min_region",
            20,
            min=0,
            max=10**6,
            soft=(0, 200),
            unit="pixels",
            label="Smallest region",
            help="Fewest pixels of a region, M: smaller ones join the nearest in colour. 0 leaves regions out.",
        ),
    ),
    run=run_mean_shift,
    packages=OPENCV,
)


def run_canny(context: Context, image: Image, mask: Image | None, *, ground: float, space: str, **canny: Any) -> Image:
    lines = filters.canny(image.encoded_mono(space, ground=ground), **canny)
    return image.with_pixels(within_mask(lines, mask), "matte")


CANNY = Node(
    type="canny",
    version=1,
    label="Canny edges",
    category="compare",
    help="Canny's edges, one pixel wide: what FDoG is compared with.",
    doc=(
        "Fig. 14b. OpenCV's, on the gradient that etf uses; low "
        "and high are parts of the frame's largest. HDR: nothing is clipped, but a bright highlight has the largest "
        "gradient and thins out all other lines, less so in acescct."
    ),
    inputs=(IMAGE, INK_MASK),
    outputs=(LINES,),
    params=(
        Param.float(
            "sigma",
            1.0,
            min=0,
            max=200,
            soft=(0, 4),
            unit="px",
            label="Blur before",
            help="Gaussian blur of the picture before.",
        ),
        Param.float(
            "low",
            0.1,
            min=0,
            max=1,
            soft=(0, 0.5),
            label="Low threshold",
            help="An edge goes on while it stays above this gradient.",
        ),
        Param.float(
            "high",
            0.2,
            min=0,
            max=1,
            soft=(0, 0.5),
            label="High threshold",
            help="An edge has to reach this gradient somewhere.",
        ),
        GROUND,
        SPACE,
    ),
    run=run_canny,
    packages=OPENCV,
)
