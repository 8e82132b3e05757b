"""Every number that comes from colour-science, written out, so that no run needs colour-science, nor SciPy with it.

In a checkout ``python -m tools.colour_science`` compares them with the installed colour-science; a test does the same.
"""

from __future__ import annotations

from typing import Final

Matrix = tuple[float, float, float, float, float, float, float, float, float]

#: RGB to CIE XYZ, row by row: ``colour.RGB_COLOURSPACES[name].matrix_RGB_to_XYZ``, under colour-science's names.
RGB_TO_XYZ: Final[dict[str, Matrix]] = {
    "ITU-R BT.709": (
        0.41239079926595934,
        0.35758433938387796,
        0.1804807884018343,
        0.2126390058715103,
        0.7151686787677559,
        0.07219231536073371,
        0.019330818715591825,
        0.11919477979462595,
        0.9505321522496606,
    ),
    "ITU-R BT.2020": (
        0.6369580483012912,
        0.1446169035862084,
        0.16888097516417208,
        0.262700212011267,
        0.6779980715188711,
        0.05930171646986195,
        4.994106574466074e-17,
        0.028072693049087445,
        1.0609850577107909,
    ),
    "P3-D65": (
        0.486570948648216,
        0.2656676931690931,
        0.1982172852343625,
        0.2289745640697487,
        0.6917385218365064,
        0.079286914093745,
        -3.9720755169334855e-17,
        0.04511338185890264,
        1.0439443689009757,
    ),
    "Adobe RGB (1998)": (
        0.57667,
        0.18556,
        0.18823,
        0.29734,
        0.62736,
        0.07529,
        0.02703,
        0.07069,
        0.99134,
    ),
    "ACEScg": (
        0.6624541811085055,
        0.13400420645643313,
        0.15618768700490773,
        0.2722287167809146,
        0.6740817658111483,
        0.05368951740793703,
        -0.005574649490394109,
        0.004060733528982825,
        1.010339100312997,
    ),
    "ACES2065-1": (
        0.9525523959,
        0.0,
        9.36786e-05,
        0.3439664498,
        0.7281660966,
        -0.0721325464,
        0.0,
        0.0,
        1.0088251844,
    ),
}

#: CIE xy of red, green, blue and white: ``primaries`` and ``whitepoint`` of the same colour spaces.
CHROMATICITIES: Final[dict[str, tuple[float, ...]]] = {
    "ITU-R BT.709": (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329),
    "ITU-R BT.2020": (0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329),
    "P3-D65": (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329),
    "Adobe RGB (1998)": (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, 0.3127, 0.329),
    "ACEScg": (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767),
    "ACES2065-1": (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767),
}

#: Cone responses of Bradford's chromatic adaptation: ``colour.CHROMATIC_ADAPTATION_TRANSFORMS["Bradford"]``.
BRADFORD: Final[Matrix] = (0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296)

#: ACEScct (Academy S-2016-001), from ``colour.models.rgb.transfer_functions.aces.CONSTANTS_ACES_CCT``. Up to ``X_BRK``
#: it is the line A x + B, above it (log2 x + 9.72) / 17.52.
ACESCCT_X_BRK: Final = 0.0078125
ACESCCT_Y_BRK: Final = 0.155251141552511
ACESCCT_A: Final = 10.5402377416545
ACESCCT_B: Final = 0.0729055341958355
ACESCCT_OFFSET: Final = 9.72
ACESCCT_SCALE: Final = 17.52
#: ACEScct of 1.0: code value 255 of the space "acescct".
ACESCCT_WHITE: Final = ACESCCT_OFFSET / ACESCCT_SCALE

#: CIE 1976 L*a*b* (CIE 15:2004): above ``LAB_EPSILON`` f is the cube root, below it (LAB_KAPPA x + 16) / 116.
LAB_EPSILON: Final = 216 / 24389
LAB_KAPPA: Final = 24389 / 27
