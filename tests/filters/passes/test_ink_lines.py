"""Lines from passes, each kind with a pen of its own."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import halo
from flowabs_nodes.filters.passes.pens import PENS, Pen
from tests.filters.flows import THIN, random_flow
from tests.naive import ink_lines as naive

RED, GREEN = (1.0, 0.0, 0.0), (0.0, 0.5, 0.0)


def line(d, width=1.5):
    """Return what aov_lines draws at a distance from an edge."""
    return np.clip(np.minimum(d, width - d) + 0.5, 0, 1).astype(np.float32)


def disc(radius=30.0, size=101, at=(50.2, 49.7)):
    """Return the distance to the edge of a disc, positive inside, and the unit tangents around it."""
    y, x = np.indices((size, size))
    x, y = x - at[0], y - at[1]
    off = np.hypot(x, y)
    distance = np.clip(radius - off, -10, 10).astype(np.float32)
    return distance, (np.stack([-y, x], -1) / np.maximum(off, 1e-6)[..., None]).astype(np.float32)


def noisy(shape=(37, 45), seed=0):
    """Return distances that jump, mattes of all kinds, and depths with the background and NaN."""
    random = np.random.default_rng(seed)
    y, x = np.indices(shape)
    distance = 10 * np.sin(x / 9 + y / 7) + np.where(x > 20, 6, 0) + random.normal(0, 0.2, shape)
    mattes = {kind: random.random(shape, np.float32) ** 2 for kind in PENS}
    depth = random.uniform(1, 40, shape)
    depth[random.random(shape) < 0.2], depth[random.random(shape) < 0.1] = 1e10, np.nan
    return distance.astype(np.float32), mattes, depth.astype(np.float32)


PENS_OF_ALL = {
    kind: Pen(width, (width, 0.5, 1 - width / 9), 0.9 - width / 10)
    for kind, width in zip(PENS, (2.5, 0.4, 6.0, 3.0, 1.0), strict=True)
}


@pytest.mark.parametrize("by_depth", [0.0, 1.0, 0.3])
def test_equals_the_formula_in_float64(by_depth):
    distance, mattes, depth = noisy()
    options = {"depth": depth, "width_by_depth": by_depth, "reference_depth": 12.0}
    found = filters.ink_lines(distance, mattes, PENS_OF_ALL, **options)
    expected = naive.ink_lines(distance, mattes, PENS_OF_ALL, **options)
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-4)
    assert found.dtype == np.float32
    assert expected[..., 3].max() > 0.5


@pytest.mark.parametrize("shape", THIN)
def test_thin_pictures(shape):
    distance, mattes, _ = noisy(shape)
    found = filters.ink_lines(distance, mattes, PENS_OF_ALL)
    np.testing.assert_allclose(found, naive.ink_lines(distance, mattes, PENS_OF_ALL), rtol=0, atol=2e-4)


@pytest.mark.parametrize("drawn", [1.0, 1.5, 3.0])
@pytest.mark.parametrize("width", [0.5, 1.0, 2.0, 4.0, 8.0])
def test_a_line_has_the_width_of_its_pen_whatever_that_of_the_matte(drawn, width):
    distance, _ = disc()
    ink = filters.ink_lines(distance, {"outline": line(distance, drawn)}, {"outline": Pen(width)})[..., 3]
    around = 2 * np.pi * (30 - width / 2)
    assert ink.sum() / around == pytest.approx(width, rel=0.02)
    assert ink[distance < -0.75].max() == 0  # all on the near side
    assert ink[(distance > 0.5) & (distance < width - 0.5)].min(initial=1) > (0.98 if drawn > 1 else 0.85)
    assert ink.max() <= 1


@pytest.mark.parametrize("width", [1.0, 3.0, 7.0])
def test_a_crease_lies_on_both_sides(width):
    distance = np.abs(disc()[0])
    matte = np.clip(0.75 - distance + 0.5, 0, 1)
    ink = filters.ink_lines(distance, {"crease": matte}, {"crease": Pen(width)})[..., 3]
    assert ink.sum() / (2 * np.pi * 30) == pytest.approx(width, rel=0.03)
    assert ink[distance > width / 2 + 0.75].max() == 0


def test_each_kind_has_its_pen_and_where_they_meet_they_are_one_line():
    distance, _ = disc()
    x = np.indices(distance.shape)[1] - 50.0
    left, right = (line(distance) * np.clip(0.5 + way * x / 4, 0, 1) for way in (-1, 1))
    pens = {"outline": Pen(3.0, RED), "object": Pen(3.0, GREEN)}
    both = filters.ink_lines(distance, {"outline": left, "object": right}, pens)
    whole = filters.ink_lines(distance, {"outline": line(distance)}, {"outline": Pen(3.0)})[..., 3]
    np.testing.assert_allclose(both[..., 3], whole, rtol=0, atol=0.02)
    np.testing.assert_allclose(both[x < -4][:, 0], whole[x < -4], rtol=0, atol=0.01)
    np.testing.assert_allclose(both[x > 4][:, 1], 0.5 * whole[x > 4], rtol=0, atol=0.01)
    assert (both[..., 2] == 0).all()


def test_outlines_lie_on_top_of_what_comes_after():
    distance, _ = disc()
    mattes = dict.fromkeys(PENS, line(distance, 3.0))
    pens = {kind: Pen(3.0, GREEN) for kind in PENS} | {"outline": Pen(3.0, RED, 0.25)}
    ink = filters.ink_lines(distance, mattes, pens)
    full = (distance > 1) & (distance < 2)
    np.testing.assert_allclose(ink[full], [[0.25, 0, 0, 0.25]] * full.sum(), atol=1e-3)


def test_a_pen_of_width_0_draws_nothing_and_faint_lines_stay_faint():
    distance, _ = disc()
    drawing = {"outline": line(distance)}
    assert filters.ink_lines(distance, drawing, {"outline": Pen(0.0)}).max() == 0
    faint = filters.ink_lines(distance, {"outline": drawing["outline"] * np.float32(0.2)})[..., 3]
    assert faint.max() == pytest.approx(0.3, abs=0.03)  # 1.5 px of a fifth


def test_lines_become_thinner_with_distance():
    distance, _ = disc(24, 120)
    x = np.indices(distance.shape)[1]
    depth = np.where(distance < 0, 1e10, np.where(x < 60, 10.0, 20.0)).astype(np.float32)
    drawing = {"outline": line(distance)}
    for exponent, ratio in ((1.0, 2.0), (0.5, 2**0.5), (0.0, 1.0)):
        ink = filters.ink_lines(distance, drawing, {"outline": Pen(4.0)}, None, depth, exponent, 10.0)[..., 3]
        near, far = ink[45:55, :50].sum(), ink[45:55, 60:].sum()
        assert near / far == pytest.approx(ratio, rel=0.05)


def test_a_jump_of_the_distance_is_no_slope():
    y, x = np.indices((40, 40))
    distance = (
        np.where(y < 20, 20.2 - x, 10.0).clip(-10, 10).astype(np.float32)
    )  # an edge that ends, far from any below
    ink = filters.ink_lines(distance, {"outline": line(distance)}, {"outline": Pen(4.0)})[..., 3]
    np.testing.assert_allclose(ink[:20].sum(1), 4.0, rtol=0.03)
    assert ink[20:].max() == 0


def test_ends_thin_out():
    distance, flow = disc(30)
    y = np.indices(distance.shape)[0]
    drawing = {"outline": line(distance) * (y < 50)}
    blunt = filters.ink_lines(distance, drawing, {"outline": Pen(4.0, RED)})
    tapered = filters.ink_lines(distance, drawing, {"outline": Pen(4.0, RED)}, flow, taper=25.0)
    np.testing.assert_array_equal(tapered[:22], blunt[:22])
    assert 0.05 < tapered[45:50].sum() / blunt[45:50].sum() < 0.6
    np.testing.assert_allclose(tapered[..., 0], tapered[..., 3], atol=1e-6)


def test_a_picture_turned_over_has_its_ink_turned_over():
    distance, mattes, depth = noisy()
    flips = np.s_[::-1, ::-1]
    one = filters.ink_lines(distance, mattes, PENS_OF_ALL, None, depth, 1.0)
    turned = {kind: matte[flips] for kind, matte in mattes.items()}
    other = filters.ink_lines(distance[flips], turned, PENS_OF_ALL, None, depth[flips], 1.0)
    np.testing.assert_allclose(other[flips], one, rtol=0, atol=1e-4)


def test_a_window_with_its_halo_has_the_same_bits():
    distance, mattes, depth = noisy((90, 100))
    for by_depth, widest in ((0.0, 6.0), (1.0, 8.0)):
        far = halo.ink_lines(widest, 0.0)
        whole = filters.ink_lines(distance, mattes, PENS_OF_ALL, None, depth, by_depth)[30:50, 40:61]
        window = slice(30 - far, 50 + far), slice(40 - far, 61 + far)
        cut = {kind: matte[window] for kind, matte in mattes.items()}
        part = filters.ink_lines(distance[window], cut, PENS_OF_ALL, None, depth[window], by_depth)
        np.testing.assert_array_equal(part[far:-far, far:-far], whole)


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    distance, mattes, depth = noisy((150, 37))
    one, *others = each_thread_count(lambda: filters.ink_lines(distance, mattes, PENS_OF_ALL, None, depth, 1.0))
    for other in others:
        np.testing.assert_array_equal(one, other)


def test_errors_name_the_argument():
    distance, mattes, _ = noisy()
    for message, arguments in {
        "expected at least one of outline, object, .* found none": {"mattes": {}},
        "mattes: there is no kind 'outlines'.*did you mean 'outline'": {"mattes": {"outlines": distance}},
        "crease: expected the size of the picture": {"mattes": {"crease": distance[1:]}},
        "distance: expected finite pixels": {"distance": np.where(distance > 9, np.nan, distance)},
        "object_width: expected a number at least 0 and at most 8": {"pens": {"object": Pen(9.0)}},
        "crease_opacity: expected a number at least 0 and at most 1": {"pens": {"crease": Pen(1.0, RED, 2.0)}},
        "pens: there is no kind 'creases'": {"pens": {"creases": Pen(1.0)}},
        "outline_color: expected three numbers, found 2": {"pens": {"outline": Pen(1.0, (0, 0))}},
        "outline_color: expected a number": {"pens": {"outline": Pen(1.0, (0, 0, float("inf")))}},
        "width_by_depth: needs the depth": {"width_by_depth": 1.0},
        "taper: needs the flow": {"taper": 4.0},
        "reference_depth: expected a number": {"reference_depth": 0.0},
        "flow: expected the size": {"taper": 4.0, "flow": random_flow((3, 3))},
    }.items():
        with pytest.raises(ArgumentError, match=message):
            filters.ink_lines(**{"distance": distance, "mattes": mattes, **arguments})
