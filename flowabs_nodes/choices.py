"""Every list of words that a parameter or an option chooses from, each list once.

Declarations of nodes, the filters' checks of their arguments, the command line and the JSON Schema all take a list from
here, those for files and hosts' pictures from :mod:`flowabs_nodes.file_choices`. A new choice is one more line there,
and the code that does what it says. This file imports nothing of the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self


class Choices(tuple[str, ...]):
    """Holds the words of one list, in the order in which they are shown.

    ``meaning`` says in a line what each does, ``label`` is its name in menus.
    """

    meaning: Mapping[str, str]
    label: Mapping[str, str]

    def __new__(cls, meaning: Mapping[str, str], label: Mapping[str, str] | None = None) -> Self:
        """Make the list from its words and their meanings; a ``label`` that is left out is made of the word."""
        words = super().__new__(cls, meaning)
        words.meaning = meaning
        words.label = {word: readable(word) for word in meaning} | dict(label or {})
        return words

    def __getnewargs__(self) -> tuple[Mapping[str, str], Mapping[str, str]]:
        """Let copies and pickles keep meanings and labels."""
        return self.meaning, self.label


def readable(name: str) -> str:
    """Return a name of code as people read it: "pre_blur" as "Pre blur"."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


# ---------------------------------------------------------------------- nodes

#: Where a menu lists a node. A node of another package may have a category of its own.
CATEGORIES = Choices(
    {
        "io": "reads and writes files",
        "flow": "makes a flow, shows it, or follows it",
        "lines": "draws lines",
        "regions": "flattens regions and cleans up their edges",
        "tone": "changes light and dark",
        "motion": "follows what moves from frame to frame",
        "merge": "puts pictures together",
        "compare": "is what the paper compares its own filters with",
        "utility": "helps other nodes",
    },
    {"io": "Input and output", "compare": "To compare with"},
)


# ---------------------------------------------------------------------- filters

#: The encodings of code values.
SPACES = Choices(
    {
        "lab": "CIE Lab, L* x 2.55: differences as the eye sees them",
        "acescct": "ACEScct, white at 255: every stop counts the same, for HDR",
    },
    {"lab": "CIE Lab", "acescct": "ACEScct"},
)

#: Where ``composite`` mixes ink and picture.
MIXING_SPACES = Choices(
    {"linear": "in scene-linear light", **SPACES.meaning}, {"linear": "Linear light", **SPACES.label}
)

#: How a picture is read between its pixels, along the flow.
SAMPLINGS = Choices(
    {
        "bilinear": "between the four pixels around a point: smoother",
        "nearest": "the nearest pixel: crisper and faster",
    },
    {"nearest": "Nearest pixel"},
)

#: The size of the picture that a filter works on.
WORKING_SCALES = Choices(
    {
        "full": "every pixel: exact",
        "auto": "1/2 or 1/4 where the lengths allow it, else full",
        "1/2": "half the width and height, a quarter of the time",
        "1/4": "a quarter of the width and height",
    },
    {"1/2": "1/2", "1/4": "1/4"},
)

#: How much a frame of ``motion_window`` counts by its distance in time.
FALLOFFS = Choices(
    {
        "gaussian": "less the farther away it is: sigma is the reach",
        "box": "all alike: steadier, and a little softer",
    }
)

#: What ``motion_window`` does where frames of its window are not there.
WINDOW_ENDS = Choices(
    {
        "shrink": "it averages the frames that are there",
        "error": "the frame fails",
    }
)

#: How carefully ``optical_flow`` looks.
FLOW_PRESETS = Choices(
    {
        "ultrafast": "coarse, ten times as fast as medium",
        "fast": "five times as fast as medium",
        "medium": "finer, for final frames",
    }
)

#: The kernel of ``etf``.
ETF_KERNELS = Choices(
    {
        "full": "the disc of eq. 2",
        "separable": "a pass along x, then one along y, in each iteration (section 2.4)",
    },
    {"full": "Disc"},
)

#: The kernel of ``fdog`` and ``fdog_iterative``.
FDOG_KERNELS = Choices(
    {
        "separable": "across the flow, then along it: eqs. 10 and 11, fast",
        "full": "eq. 6, sampled point by point",
    }
)

#: What the numbers of a depth pass are.
PROJECTIONS = Choices(
    {
        "planar": "Z, along the camera's axis",
        "distance": "the way from the camera along the ray",
        "orthographic": "Z of a camera without perspective",
    }
)

#: Which lines ``dog``, ``fdog`` and ``fdog_iterative`` draw.
FORMS = Choices(
    {
        "paper": "the paper's, eqs. 8 and 9: by rho, tau, contrast and softness",
        "xdog": "XDoG's, which fade into tone: by p, epsilon and phi",
    },
    {"paper": "The paper's", "xdog": "XDoG"},
)

#: The neighbours that ``bilateral`` weighs.
BILATERAL_KERNELS = Choices(
    {
        "full": "all neighbours in a square",
        "xy": "those along x, then those along y: fast, axis-aligned",
    },
    {"full": "Square", "xy": "X, then Y"},
)

#: The curve that ``bilateral_oriented`` follows.
ORIENTED_KERNELS = Choices(
    {
        "line": "the tangent of the flow",
        "arc": "a parabola bent like the flow",
    }
)

# ---------------------------------------------------------------------- comps

#: What ``merge`` makes of A, B and their alphas a, b: Nuke's operations and formulas.
MERGE_OPERATIONS = Choices(
    {
        "over": "A + B(1 - a)",
        "under": "A(1 - b) + B",
        "plus": "A + B",
        "minus": "A - B",
        "multiply": "A B",
        "screen": "A + B - A B where both are 0 to 1, else the larger",
        "min": "the smaller of A and B",
        "max": "the larger of A and B",
        "difference": "the distance of A and B",
        "mask": "B a",
        "stencil": "B(1 - a)",
    }
)

#: How ``reformat`` weighs pixels: OpenImageIO's filters.
RESIZE_FILTERS = Choices(
    {
        "blackman-harris": "smooth, without ringing",
        "lanczos3": "sharp; rings beside highlights",
        "box": "the mean; whole steps when enlarged",
        "triangle": "linear between pixels, without ringing",
        "gaussian": "soft, without ringing",
        "catmull-rom": "sharp, rings a little",
        "mitchell": "between soft and sharp, rings a little",
        "bspline": "softest, without ringing",
    },
    {"catmull-rom": "Catmull-Rom", "bspline": "B-spline"},
)

#: How ``reformat`` puts a picture into another format: OpenImageIO's fill modes of fit, and its resize.
FITS = Choices(
    {
        "letterbox": "as large as fits, the rest transparent",
        "width": "as wide as the format, whatever its height becomes",
        "height": "as high as the format, whatever its width becomes",
        "distort": "stretched to the format",
    }
)
