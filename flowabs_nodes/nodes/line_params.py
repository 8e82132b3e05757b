"""Declares the parameters of the nodes that draw lines: ``dog``, ``fdog`` and ``fdog_iterative`` share most of them."""

from __future__ import annotations

from flowabs_nodes.choices import FDOG_KERNELS, FORMS
from flowabs_nodes.nodes.common_params import GROUND, SPACE, sampling
from flowabs_nodes.nodes.declare import Param
from flowabs_nodes.nodes.working_scale import WORKING_SCALE

FORM = Param.enum(
    "form",
    "paper",
    FORMS,
    help="Which lines: the paper's, by rho, tau, contrast and softness, or XDoG's, which fade into tone, by p, epsilon "
    "and phi.",
)

#: The forms beside which a parameter does something.
PAPER_FORM, XDOG_FORM = {"form": ("paper",)}, {"form": ("xdog",)}

#: The difference of Gaussians, eq. 8.
DIFFERENCE = (
    Param.float(
        "sigma_c",
        1.0,
        min=0.05,
        max=200,
        soft=(0.3, 4),
        unit="px",
        thin_below=1.0,
        floor=0.4,
        label="Line width",
        group="Response",
        help="Centre Gaussian: sets the width of the line.",
    ),
    Param.float(
        "rho",
        0.99,
        min=0,
        max=2,
        soft=(0.9, 1),
        label="Surround (rho)",
        group="Response",
        enabled_when=PAPER_FORM,
        help="Weight of the surround: more lines, and more noise, the nearer to 1.",
    ),
)

#: From response to lines, eq. 9.
THRESHOLD = (
    Param.float(
        "tau",
        0.5,
        min=0,
        max=1,
        soft=(0, 1),
        label="Threshold (tau)",
        group="Lines",
        enabled_when=PAPER_FORM,
        help="Threshold of eq. 9: higher draws more, 0 nothing. Not used when contrast is set.",
    ),
    Param.float(
        "contrast",
        None,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        nullable=True,
        group="Lines",
        enabled_when=PAPER_FORM,
        help="Ink where the response is below minus this; higher draws less. null: from tau, -atanh(tau - 1).",
    ),
    Param.float(
        "softness",
        0.0,
        min=0,
        max=1000,
        soft=(0, 10),
        unit="code values",
        group="Lines",
        enabled_when=PAPER_FORM,
        help="Width of the ramp from ink to paper: anti-aliased, steadier in motion. 0 is black and white (the paper).",
    ),
)

#: XDoG's form of both.
XDOG = (
    Param.float(
        "p",
        20.0,
        min=0,
        max=1000,
        soft=(0, 100),
        label="Edge strength (p)",
        group="XDoG",
        enabled_when=XDOG_FORM,
        help="Strength of the edges; 0 is tone alone. Takes rho's place, as p / (1 + p).",
    ),
    Param.float(
        "epsilon",
        0.0,
        min=-10_000,
        max=10_000,
        soft=(0, 255),
        unit="code values",
        label="Tone level (epsilon)",
        group="XDoG",
        enabled_when=XDOG_FORM,
        help="Tone below this level darkens; 0 draws edges alone, 255 fills all but their bright sides.",
    ),
    Param.float(
        "phi",
        0.01,
        min=0,
        max=1000,
        soft=(0, 1),
        unit="per code value",
        label="Steepness (phi)",
        group="XDoG",
        enabled_when=XDOG_FORM,
        help="Steepness of the way to black; low is soft like pastel, high is black ink.",
    ),
)

#: Outlines that are softer than a line.
SOFT = (
    Param.float(
        "soft_lines",
        0.0,
        min=0,
        max=1,
        soft=(0, 1),
        label="Soft outlines",
        group="Soft outlines",
        help="Draw blurred outlines (a jaw, hair, a ground out of focus) as one line of normal width: how much of it. "
        "0 leaves them to the line filter, which fades with the blur.",
    ),
    Param.float(
        "soft_reach",
        7.0,
        min=1,
        max=1000,
        soft=(3, 12),
        unit="px",
        floor=2.0,
        label="Softest outline",
        group="Soft outlines",
        help="Blur (sigma) of the softest outlines that soft_lines draws: lower leaves grounds out of focus alone, "
        "higher finds folds and shading too.",
    ),
)

#: Lines that are thinner than two lines of ink side by side.
THIN = (
    Param.float(
        "thin_lines",
        0.0,
        min=0,
        max=1000,
        soft=(0, 8),
        unit="px",
        label="Thin bright lines",
        group="Response",
        help="Draw bright lines up to this width (a whisker, a cable, a rim of light) as one line on their middle. 0 "
        "draws one along each side of them.",
        later=True,
    ),
)

#: What FDoG takes beside the parameters above.
ALONG_FLOW = (
    Param.float(
        "color_weight",
        0.0,
        min=0,
        max=10,
        soft=(0, 1),
        label="Colour weight",
        group="Response",
        enabled_when=PAPER_FORM,
        help="How much differences of colour add to those of lightness; 0 is lightness alone (the paper).",
    ),
    Param.bool(
        "color_sign",
        False,
        label="Edges of equal lightness",
        group="Response",
        enabled_when=PAPER_FORM,
        help="Draw edges between colours of equal lightness too, where color_weight is above 0: colour then says which "
        "side is the dark one. false leaves them out.",
    ),
    Param.float(
        "evidence",
        0.0,
        min=0,
        max=1,
        soft=(0, 1),
        label="Evidence along the line",
        group="Response",
        enabled_when=PAPER_FORM,
        help="How much ink needs more ink along a longer stretch of the flow: specks and texture fade; 0 is off.",
    ),
    Param.float(
        "lone_lines",
        0.0,
        min=0,
        max=1000,
        soft=(0, 12),
        label="Lone faint lines",
        group="Response",
        enabled_when=PAPER_FORM,
        help="How many times its own strength a faint line gains where no other ink is near: a tower in haze, a cable. "
        "Texture and noise gain nothing. 0 is off.",
        later=True,
    ),
    Param.float(
        "smooth",
        0.0,
        min=0,
        max=200,
        soft=(0, 4),
        unit="px",
        label="Smooth along the flow",
        group="Lines",
        help="Gaussian blur of the lines along the flow: anti-aliasing lengthwise.",
    ),
    Param.enum(
        "kernel",
        "separable",
        FDOG_KERNELS,
        group="Sampling",
        help="Eqs. 10 and 11 (fast), or eq. 6 sampled point by point.",
    ),
    sampling("bilinear"),
    WORKING_SCALE,
    GROUND,
    SPACE,
)

SIGMA_M = Param.float(
    "sigma_m",
    3.0,
    min=0,
    max=500,
    soft=(1, 10),
    unit="px",
    label="Line length",
    group="Response",
    help="Gaussian along the flow: longer, more coherent lines.",
)
