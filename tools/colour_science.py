"""Hold the numbers of ``flowabs_nodes/color/constants.py`` to colour-science, which they were taken from.

``python -m tools.colour_science`` prints each that differs, as it is there and as the installed colour-science has it;
a test does the same. colour-science is installed with the extra ``test`` only: nothing imports it in a run.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any

from flowabs_nodes.color import constants

Pairs = dict[str, tuple[Sequence[float], Sequence[float]]]


def _colour() -> Any:
    """Return the module ``colour``, imported without its warnings about optional packages."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour


def pairs() -> Pairs:
    """Return for each constant, by what it is, our numbers and colour-science's."""
    colour = _colour()
    from colour.models.rgb.transfer_functions.aces import CONSTANTS_ACES_CCT as CCT

    lightness = colour.colorimetry.intermediate_lightness_function_CIE1976
    offset, scale = constants.ACESCCT_OFFSET, constants.ACESCCT_SCALE
    kappa, epsilon = constants.LAB_KAPPA, constants.LAB_EPSILON
    found: Pairs = {
        "BRADFORD": (constants.BRADFORD, colour.CHROMATIC_ADAPTATION_TRANSFORMS["Bradford"].ravel()),
        "ACESCCT_X_BRK, Y_BRK, A, B": (
            (constants.ACESCCT_X_BRK, constants.ACESCCT_Y_BRK, constants.ACESCCT_A, constants.ACESCCT_B),
            (CCT.X_BRK, CCT.Y_BRK, CCT.A, CCT.B),
        ),
        "ACEScct of 1 and 2": (
            (constants.ACESCCT_WHITE, (1 + offset) / scale),
            (colour.models.log_encoding_ACEScct(1.0), colour.models.log_encoding_ACEScct(2.0)),
        ),
        "CIE f of 0, LAB_EPSILON and 1": (
            (16 / 116, (kappa * epsilon + 16) / 116, 1.0),
            (lightness(0.0, 1.0), lightness(epsilon, 1.0), lightness(1.0, 1.0)),
        ),
    }
    for name, matrix in constants.RGB_TO_XYZ.items():
        space = colour.RGB_COLOURSPACES[name]
        found[f"RGB_TO_XYZ of {name}"] = matrix, space.matrix_RGB_to_XYZ.ravel()
        found[f"CHROMATICITIES of {name}"] = (
            constants.CHROMATICITIES[name],
            (*space.primaries.ravel(), *space.whitepoint),
        )
    return found


def differences() -> list[str]:
    """Return a line for each constant that is further than 1e-12 from the installed colour-science's."""
    return [
        f"{what}: {tuple(ours)} here, {tuple(map(float, theirs))} in colour-science {_colour().__version__}"
        for what, (ours, theirs) in pairs().items()
        if not all(math.isclose(a, b, rel_tol=0, abs_tol=1e-12) for a, b in zip(ours, theirs, strict=True))
    ]


if __name__ == "__main__":
    print("\n".join(differences()) or "every number is colour-science's")
