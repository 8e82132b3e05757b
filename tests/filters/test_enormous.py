"""Numbers that no picture holds: what comes out of a filter is finite, or the argument is refused with its place."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError

SIZE = (23, 37)
BASE = (np.random.default_rng(0).random((*SIZE, 3)) * 255).astype(np.float32)
FLOW = filters.etf(BASE[..., 0])
LINES = np.random.default_rng(1).random(SIZE).astype(np.float32)


def grey(picture):
    return np.ascontiguousarray(picture[..., 1])


FILTERS = {
    "etf": lambda picture: filters.etf(picture, fill=4, pre_blur=1),
    "fdog": lambda picture: filters.fdog(grey(picture), FLOW),
    "fdog of colours": lambda picture: filters.fdog(picture, FLOW, color_weight=0.5),
    "fdog of colours that count most": lambda picture: filters.fdog(picture, FLOW, color_weight=1e6),
    "fdog by evidence": lambda picture: filters.fdog(picture, FLOW, color_weight=0.5, evidence=1.0),
    "fdog of lightness by evidence": lambda picture: filters.fdog(grey(picture), FLOW, evidence=0.5),
    "fdog with lone lines": lambda picture: filters.fdog(picture, FLOW, color_weight=0.5, lone_lines=9.0),
    "fdog, full": lambda picture: filters.fdog(grey(picture), FLOW, kernel="full"),
    "fdog, iterative": lambda picture: filters.fdog_iterative(picture, FLOW, color_weight=0.5)[1],
    "fdog with soft lines": lambda picture: filters.fdog(picture, FLOW, color_weight=1.0, soft_lines=1.0),
    "fdog with thin lines": lambda picture: filters.fdog(grey(picture), FLOW, thin_lines=3.0),
    "dog": lambda picture: filters.dog(grey(picture)),
    "threshold": lambda picture: filters.threshold(grey(picture), softness=4),
    "fbl": lambda picture: filters.fbl(picture, FLOW),
    "fbl under alpha": lambda picture: filters.fbl(picture, FLOW, sampling="bilinear", alpha=LINES),
    "fbl that tells no colours apart": lambda picture: filters.fbl(picture, FLOW, sigma_e=20, r_e=1e30, r_g=1e30),
    "fbl at half the size": lambda picture: filters.fbl(picture, FLOW, alpha=LINES, working_scale="1/2"),
    "fdog at half the size": lambda picture: filters.fdog(picture, FLOW, color_weight=0.5, working_scale="1/2"),
    "etf at half the size": lambda picture: filters.etf(picture, fill=4, pre_blur=1, working_scale="1/2"),
    "etf beside edges that are known": lambda picture: filters.etf(
        picture, edge_strength=LINES, edge_flow=FLOW, edge_weight=1e6
    ),
    "bilateral": filters.bilateral,
    "bilateral that tells no colours apart": lambda picture: filters.bilateral(picture, 6, 1e30, kernel="xy"),
    "rolling_guidance": filters.rolling_guidance,
    "rolling_guidance that tells no colours apart": lambda picture: filters.rolling_guidance(picture, 6, 1e30),
    "shoulder": filters.shoulder,
    "bilateral_oriented": lambda picture: filters.bilateral_oriented(picture, FLOW, kernel="arc"),
    "mean_shift": lambda picture: filters.mean_shift(picture),
    "canny": lambda picture: filters.canny(grey(picture)),
    "quantize": lambda picture: filters.quantize(grey(picture), 1000, 0.5),
    "quantize, hard": lambda picture: filters.quantize(grey(picture)),
    "quantize by the gradient": lambda picture: filters.quantize(grey(picture), 10, 0.5, 0.3, by_gradient=1.0),
    "blur": lambda picture: filters.blur(picture, 2),
    "flow_blur": lambda picture: filters.flow_blur(picture, FLOW),
    "composite": lambda picture: filters.composite(picture, LINES, (3e38, 1, -3e38)),
    "composite under alpha": lambda picture: filters.composite(BASE, LINES, (3, 1, 1), alpha=grey(picture)),
    "lic": lambda picture: filters.lic(picture[..., :2]),
}


def pictures(value):
    """Return pictures that hold the value at one pixel, in one half, in rows by turns with its negative, everywhere."""
    one, half, rows = BASE.copy(), BASE.copy(), BASE.copy()
    one[11, 20] = value
    half[:, 18:] = value
    rows[::2], rows[1::2] = value, -value
    return [one, -one, half, rows, np.full_like(BASE, value)]


def result_or_error(name, picture):
    try:
        return FILTERS[name](picture)
    except ArgumentError as error:
        return error


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("value", [3e38, 1e35, 1e33, 1e30, 1e20])
@pytest.mark.parametrize("name", FILTERS)
def test_finite_or_refused_by_name(name, value):
    if name in ("mean_shift", "canny"):
        pytest.importorskip("cv2")
    for picture in pictures(value):
        outcome = result_or_error(name, picture)
        if isinstance(outcome, ArgumentError):
            assert value > 1e34, "small enough to be summed"
            assert outcome.parameter in ("code", "codes", "image", "alpha", "lstar")
            assert " at x " in str(outcome)
        else:
            assert np.isfinite(outcome).all()


@pytest.mark.parametrize("weight", [1e20, 1.1e6, -1, np.inf, np.nan])
def test_a_weight_of_colour_out_of_range_is_refused(weight):
    with pytest.raises(ArgumentError, match=r"color_weight: expected a number at least 0 and at most 1e\+06"):
        filters.fdog(BASE, FLOW, color_weight=weight)
