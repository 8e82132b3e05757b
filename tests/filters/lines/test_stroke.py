import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import halo, stroke
from tests.filters.flows import THIN, cases, random_flow
from tests.naive import stroke as naive

#: Of what the filter does, one thing, then all.
RULES = [{"min_length": 12.0}, {"taper": 8.0}, {"min_length": 6.0, "taper": 10.0}]


def level(shape):
    """Return a flow along x, (H, W, 2)."""
    flow = np.zeros((*shape, 2), np.float32)
    flow[..., 0] = 1
    return flow


def dash(length, width=3, size=(31, 121)):
    """Return a drawing of one horizontal stroke, in the middle."""
    lines = np.ones(size, np.float32)
    y, x = (size[0] - width) // 2, (size[1] - length) // 2
    lines[y : y + width, x : x + length] = 0
    return lines


def ring(radius, size=121):
    """Return a drawing of a circle of 3 px, soft, and the flow along it."""
    y, x = np.mgrid[:size, :size] - (size - 1) / 2
    off = np.hypot(x, y)
    flow = np.stack([-y, x], -1) / np.maximum(off, 1e-6)[..., None]
    return np.clip(np.abs(off - radius) - 1, 0, 1).astype(np.float32), flow.astype(np.float32)


def width_at(lines, x):
    """Return how much ink there is in column x."""
    return float((1 - lines[:, x]).sum())


@pytest.mark.parametrize("rule", RULES)
def test_equals_the_formulas_in_float64(rule):
    code, flow = cases()["photo"]
    response = filters.fdog(code[..., 0], flow, rho=1.0)
    lines = filters.threshold(response, contrast=0.5, softness=4.0)
    for strength in (0.0, 6.0):
        found = stroke(lines, flow, **rule, strength=strength, response=response)
        expected = naive.stroke(lines, flow, **rule, strength=strength, response=response)
        assert np.abs(expected - lines).max() > 0.3
        np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4)


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    lines = np.random.default_rng(1).random(shape, np.float32)
    flow = random_flow(shape, 2)
    np.testing.assert_allclose(stroke(lines, flow, 4.0, 3.0), naive.stroke(lines, flow, 4.0, 3.0), rtol=0, atol=2e-4)


def test_a_short_stroke_goes_and_a_long_one_stays():
    short, long = dash(10), dash(40)
    assert (stroke(short, level(short.shape), min_length=20) == 1).all()
    np.testing.assert_array_equal(stroke(long, level(long.shape), min_length=20), long)


def test_a_stroke_of_the_shortest_length_is_half_as_wide():
    lines = dash(20, width=8)
    assert width_at(stroke(lines, level(lines.shape), min_length=20), 60) == pytest.approx(4, abs=0.1)


def test_nothing_pops_as_a_stroke_grows():
    ink = [float((1 - stroke(dash(n), level((31, 121)), 20, 6)).sum()) for n in range(8, 40)]
    steps = np.diff(ink)
    assert steps.min() >= 0
    assert steps.max() < 0.15 * ink[-1]


def test_a_gap_of_a_pixel_ends_no_stroke():
    lines = dash(40)
    lines[:, 60] = 1
    ink = 1 - stroke(lines, level(lines.shape), min_length=20)
    assert ink.sum() > 0.95 * (1 - lines).sum()
    lines[:, 50:70] = 1  # two strokes of ten pixels, twenty apart
    assert (stroke(lines, level(lines.shape), min_length=20) == 1).mean() == 1


@pytest.mark.parametrize("width", [2, 3, 8])
def test_ends_taper_and_the_middle_stays(width):
    lines = dash(81, width)
    drawn = stroke(lines, level(lines.shape), taper=20)
    widths = [width_at(drawn, x) for x in range(20, 61)]
    assert (np.diff(widths) >= -1e-5).all()
    assert widths[0] < 0.2 * width
    assert 0.3 * width < widths[5] < 0.8 * width
    np.testing.assert_array_equal(drawn[:, 45:76], lines[:, 45:76])
    np.testing.assert_allclose(drawn, drawn[:, ::-1], rtol=0, atol=1e-6)


def test_a_closed_line_has_no_ends():
    lines, flow = ring(40)
    np.testing.assert_array_equal(stroke(lines, flow, min_length=60, taper=40), lines)


def test_small_rings_stay():
    lines, flow = ring(8)
    drawn = stroke(lines, flow, min_length=20, taper=10)
    assert (1 - drawn).sum() > 0.9 * (1 - lines).sum()


def test_weak_strokes_are_narrow():
    lines = np.minimum(dash(80), np.roll(dash(80), 12, axis=0))
    response = np.where(lines == 0, np.where(np.arange(31)[:, None] < 20, -5, -20), 0).astype(np.float32)
    drawn = stroke(lines, level(lines.shape), strength=10, response=response)
    weak, strong = (1 - drawn[:20, 60]).sum(), (1 - drawn[20:, 60]).sum()
    assert strong == 3
    assert 1 < weak < 2


def test_no_pixel_becomes_darker_and_nothing_changes_without_a_rule():
    code, flow = cases()["photo"]
    lines = filters.threshold(filters.fdog(code[..., 0], flow), softness=4.0)
    np.testing.assert_array_equal(stroke(lines, flow), lines)
    assert stroke(lines, flow) is not lines
    assert (stroke(lines, flow, 10, 10) >= lines).all()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 5), st.integers(0, 5))
def test_a_shift_of_the_drawing_shifts_the_result(down, right):
    lines, flow = ring(12, 61)
    lines[:, 30:] = 1
    one = stroke(lines, flow, 20, 8)
    shift = {"shift": (down, right), "axis": (0, 1)}
    other = stroke(np.roll(lines, **shift), np.roll(flow, **shift), 20, 8)
    np.testing.assert_array_equal(np.roll(one, **shift)[8:-8, 8:-8], other[8:-8, 8:-8])


def test_the_sign_of_the_flow_does_not_count():
    code, flow = cases()["photo"]
    lines = filters.threshold(filters.fdog(code[..., 0], flow), softness=4.0)
    signs = np.random.default_rng(3).choice([-1, 1], flow.shape[:2])[..., None].astype(np.float32)
    np.testing.assert_allclose(stroke(lines, flow * signs, 10, 6), stroke(lines, flow, 10, 6), rtol=0, atol=2e-4)


def test_a_window_with_its_halo_has_the_same_bits():
    code, flow = cases()["photo"]
    lines = filters.threshold(filters.fdog(code[..., 0], flow), softness=4.0)
    lines, flow = np.tile(lines, (3, 3)), np.tile(flow, (3, 3, 1))
    far = halo.stroke(8.0, 5.0)
    whole = stroke(lines, flow, 8.0, 5.0)[90:110, 80:121]
    window = slice(90 - far, 110 + far), slice(80 - far, 121 + far)
    part = stroke(lines[window], flow[window], 8.0, 5.0)[far:-far, far:-far]
    np.testing.assert_array_equal(part, whole)


def test_the_number_of_threads_changes_no_bit(each_thread_count):
    code, flow = cases()["photo"]
    lines = filters.threshold(filters.fdog(code[..., 0], flow), softness=4.0)
    one, *others = each_thread_count(lambda: stroke(lines, flow, 10, 6))
    for other in others:
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"lines": np.zeros((4, 5, 3))}, "lines: expected shape"),
        ({"lines": np.full((4, 5), np.nan)}, "lines: "),
        ({"flow": np.zeros((4, 6, 2))}, "flow: expected the size of the picture, 5x4, found 6x4"),
        ({"min_length": -1}, "min_length: expected a number at least 0"),
        ({"taper": np.inf}, "taper: expected a number at least 0"),
        ({"strength": -1}, "strength: expected a number at least 0"),
        ({"strength": 1}, "strength: needs the response of the lines"),
        ({"strength": 1, "response": np.zeros((5, 5))}, "response: expected the size of the picture"),
    ],
)
def test_errors(arguments, text):
    with pytest.raises(ArgumentError, match=text):
        stroke(**({"lines": np.zeros((4, 5)), "flow": np.zeros((4, 5, 2))} | arguments))
