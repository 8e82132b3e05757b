"""Lines from passes: the naive twin, drawn scenes of each kind, properties, and what is refused."""

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters.passes.affine_depth import View
from tests.filters.passes.scenes import disc, disc_before_wall, floor_to_horizon, grid, roof, wall
from tests.naive import aov_lines as naive

KINDS = ("outline", "object", "material", "crease", "intersection")


def ink_of(made):
    return np.stack([getattr(made, kind) for kind in KINDS])


@pytest.mark.parametrize("passes", ["depth", "id", "depth and id"])
def test_it_is_its_naive_twin(passes):
    depth, ids = disc_before_wall(30, 44)
    rng = np.random.default_rng(4)
    depth = np.where(rng.random(depth.shape) < 0.01, np.float32(np.inf), depth)
    given = {"depth": depth if "depth" in passes else None, "id": ids if "id" in passes else None}
    made = filters.aov_lines(**given, width=2.2)
    ink, distance = naive.silhouettes(given["depth"], given["id"], width=2.2)
    differ = np.abs(ink_of(made) - ink).max(axis=0) > 1e-4
    assert differ.mean() < 0.005  # two points may be equally near
    assert np.median(np.abs(made.distance - distance)) < 1e-5
    assert (np.abs(made.distance - distance) > 1e-3).mean() < 0.01


def test_the_ids_of_materials_are_as_the_naive_twin_has_them():
    _, ids = disc_before_wall(30, 44)
    depth = wall(30, 44).astype(np.float32)
    one = np.full_like(ids, 4)
    made = filters.aov_lines(depth, id=one, material=ids)
    ink, _ = naive.silhouettes(depth, one, ids)
    np.testing.assert_allclose(ink_of(made), ink, atol=1e-4)
    assert made.material.sum() > 50
    assert made.lines.min() == pytest.approx(1 - made.material.max())


@pytest.mark.parametrize("width", [1.0, 2.0, 3.0, 4.0])
def test_a_line_has_the_width_asked_for_on_the_near_side(width):
    depth, ids = disc_before_wall()
    for passes in ({"depth": depth}, {"depth": depth, "id": ids}, {"id": ids}):
        made = filters.aov_lines(**passes, width=width)
        ink = 1 - made.lines
        radius = 11 - width / 2  # of the middle of the line
        assert ink.sum() / (2 * np.pi * radius) == pytest.approx(width, rel=0.05)
        assert ink[~disc(radius=12)].max() == 0
        assert ink[disc(radius=11)].sum() > (0.8 if width == 1 else 0.9) * ink.sum()


def test_distances_are_those_to_the_circle_whatever_the_width():
    depth, ids = disc_before_wall()
    y, x = grid()
    true = 11 - np.hypot(y - 18.3, x - 24.7)
    one, other = filters.aov_lines(depth, id=ids), filters.aov_lines(depth, id=ids, width=4.0)
    near = np.abs(true) < 9
    assert np.abs(one.distance - true)[near].max() < 0.4
    assert np.abs(one.distance - true)[near].mean() < 0.12
    assert (one.distance[np.abs(true) > 11] == 10).all()
    np.testing.assert_array_equal(one.distance, other.distance)
    assert (one.strength[np.abs(true) < 1.5] > 0.99).all()
    assert (one.strength[np.abs(true) > 3.5] == 0).all()


def test_the_flow_goes_round_a_disc():
    depth, ids = disc_before_wall()
    flow = filters.aov_lines(depth, id=ids).flow
    y, x = grid()
    dy, dx = y - 18.3, x - 24.7
    size = np.hypot(dx, dy)
    across = np.abs(flow[..., 0] * dx + flow[..., 1] * dy) / np.maximum(size, 1)
    assert across[np.abs(size - 11) < 2].max() < 0.3
    np.testing.assert_allclose(np.linalg.norm(flow, axis=2), 1, atol=1e-5)


# ---------------------------------------------------------------------- kinds


def inked(made):
    return {kind for kind in KINDS if getattr(made, kind).max() > 0.5}


def test_an_object_before_the_background_has_an_outline():
    there = disc()
    depth = np.where(there, 5.0, 1e10)
    assert inked(filters.aov_lines(depth)) == {"outline"}
    assert inked(filters.aov_lines(id=there.astype(np.uint32))) == {"outline"}
    # Id 0 is the background even where the depth pass has something nearer, such as glass that has no id.
    assert inked(filters.aov_lines(np.where(there, 5.0, 3.0), id=there.astype(np.uint32))) == {"outline"}


def test_an_object_before_another_and_one_that_touches_it():
    depth, ids = disc_before_wall()
    assert inked(filters.aov_lines(depth, id=ids)) == {"object"}
    assert inked(filters.aov_lines(depth)) == {"object"}
    assert inked(filters.aov_lines(wall(), id=ids)) == {"intersection"}
    assert inked(filters.aov_lines(id=ids)) == {"object"}  # without depth nobody knows whether they touch


def test_a_box_on_a_floor_is_drawn_inside_and_on_both_where_they_touch():
    y, x = grid()
    floor, face = 0.02 + 0.004 * y, 0.02 + 0.004 * 30.5  # they touch at y = 30.5
    box = (y > 18) & (y < 30.5) & (x > 14) & (x < 40)
    depth, ids = 1 / np.where(box, face, floor), np.where(box, 2, 9).astype(np.uint32)
    for width, below in ((1.5, 0.5), (4.0, 0.25)):
        made = filters.aov_lines(depth, id=ids, width=width)
        assert inked(made) == {"object", "intersection"}
        ink = 1 - made.lines
        around = box | (y > 29)  # but for the corners of the contact
        assert ink[~around].sum() < 0.1 * ink.sum()
        contact = ink[27:34, 22:32].sum(axis=1)
        assert contact.sum() == pytest.approx(10 * width, rel=0.02)
        assert contact[4:].sum() == pytest.approx(below * contact.sum(), rel=0.1)
        assert made.object[:22].sum() > 0
        assert made.intersection[:22].sum() == 0
        # On the way there is no step: from column to column the middle of the line moves little.
        line = ink[26:36, 15:39]
        middle = (line * y[26:36, 15:39]).sum(axis=0) / line.sum(axis=0)
        assert np.abs(np.diff(middle[4:-4])).max() < 0.2


def test_what_touches_in_a_spot_keeps_its_outline():
    y, x = grid()
    floor = 0.02 + 0.004 * y
    ball = (y - 20) ** 2 + (x - 30.3) ** 2 < 12.4**2
    lowest = 0.02 + 0.004 * 32.6  # as far as the floor below it
    depth, ids = 1 / np.where(ball, lowest, floor), np.where(ball, 2, 9).astype(np.uint32)
    ink = 1 - filters.aov_lines(depth, id=ids).lines
    assert ink[~ball].sum() < 0.1 * ink.sum()


def test_materials_within_an_object_and_where_it_folds_over_itself():
    depth, ids = disc_before_wall()
    one = np.full_like(ids, 5)
    assert inked(filters.aov_lines(id=one, material=ids)) == {"material"}
    assert inked(filters.aov_lines(wall(), id=one, material=ids)) == {"material"}
    assert inked(filters.aov_lines(depth, id=one, material=ids)) == {"object"}


def test_a_horizon_goes_up_to_the_object_before_it_and_makes_no_specks():
    y, x = grid(48, 80)
    horizon = 20.3 + 0.06 * x
    ball = (y - 26) ** 2 + (x - 41.4) ** 2 < 12.6**2
    floor = np.where(y > horizon, 9.0, np.inf)  # the far end of a floor
    for depth, ids in (
        (np.where(ball, 4.0, floor), None),
        (np.where(ball, 4.0, floor), np.where(ball, 5, np.where(y > horizon, 8, 0)).astype(np.uint32)),
    ):
        made = filters.aov_lines(depth, id=ids)
        ink = 1 - made.lines
        beside = np.hypot(y - 26, x - 41.4) - 12.6  # px outside the ball
        on_horizon = np.abs(y - horizon - 0.75) < 2
        up_to = np.where(on_horizon, beside, 10).min(axis=0) > 0
        assert (ink * on_horizon).sum(axis=0)[up_to].min() > 1.0
        near = (np.abs(beside + 0.75) < 1.6) | on_horizon
        assert ink[~near].max() < 0.05


def test_a_speck_is_no_line():
    depth = wall()
    depth[20, 30], depth[8, 8:10] = 3.0, 3.0
    assert filters.aov_lines(depth).lines.min() > 0.6
    depth[30, 10:40] = 3.0  # and a wire is one
    ink = 1 - filters.aov_lines(depth).lines
    assert ink[30, 12:38].min() > 0.9
    assert ink[28:33, 14:36].sum(axis=0).max() < 1.6


# ---------------------------------------------------------------------- creases


def test_a_crease_of_a_known_angle():
    normals, d = roof(50.0)
    made = filters.aov_lines(normal=normals, crease_width=2.0)
    assert inked(made) == {"crease"}
    inside = (slice(4, -4), slice(4, -4))
    np.testing.assert_allclose(made.crease[inside], np.clip(1 - np.abs(d) + 0.5, 0, 1)[inside], atol=0.3)
    per_row = made.crease[4:-4].sum(axis=1) / np.hypot(1, 0.3)
    np.testing.assert_allclose(per_row.mean(), 2.0, rtol=0.05)
    assert np.abs(made.distance[inside] - np.abs(d)[inside])[np.abs(d)[inside] < 9].max() < 0.4


def test_creases_by_their_angle_and_bends_are_none():
    for angle, expected in ((12, 0.0), (45, 1.0)):
        made = filters.aov_lines(normal=roof(angle)[0])
        assert made.crease[10:30].max(axis=1).mean() == pytest.approx(expected, abs=0.2)
    _, x = grid()
    turn = np.radians(4.0) * x  # a cylinder: 4 degrees a pixel everywhere
    bend = np.stack([np.sin(turn), 0 * turn, np.cos(turn)], axis=2)
    assert filters.aov_lines(normal=bend).lines.min() == 1
    blunt = np.radians(np.clip(15 * (x - 26), 0, 60))  # 60 degrees over 4 px
    fold = np.stack([np.sin(blunt), 0 * blunt, np.cos(blunt)], axis=2)
    assert filters.aov_lines(normal=fold).crease.max() < filters.aov_lines(normal=fold, crease_reach=3.0).crease.max()


def test_a_crease_goes_up_to_the_silhouette_and_not_along_it():
    normals, d = roof(80.0)
    there = disc(radius=15)
    normals[~there] = (0, 1, 0)  # at the silhouette normals turn too
    depth = np.where(there, 5.0, 9.0)
    made = filters.aov_lines(depth, normals)
    along = np.abs(d) < 0.5
    ink = 1 - made.lines
    assert ink[along & there].min() > 0.4
    assert made.crease[(np.abs(d) > 4)].max() < 0.1


# ---------------------------------------------------------------------- depth


@pytest.mark.parametrize("scale", [1, 1000])
def test_a_plane_to_the_horizon_in_halves_makes_no_line(scale):
    with np.errstate(over="ignore"):
        depth = floor_to_horizon(scale).astype(np.float16).astype(np.float32)
    assert filters.aov_lines(depth).lines.min() == 1
    assert filters.aov_lines(np.minimum(depth, 65504)).lines.min() == 1
    assert filters.aov_lines(np.where(depth < 65504, depth, 1e10)).lines.min() == 1


def test_the_unit_of_depth_does_not_matter():
    depth, ids = disc_before_wall()
    for passes in ({}, {"id": ids}):
        made = filters.aov_lines(depth, **passes)
        for factor in (2.0**-7, 2.0**9):
            again = filters.aov_lines(depth * np.float32(factor), **passes)
            for one, other in zip(made, again, strict=True):
                np.testing.assert_array_equal(one, other)
        again = filters.aov_lines(depth * np.float32(3.7), **passes)
        np.testing.assert_allclose(again.lines, made.lines, atol=1e-3)


def test_projections():
    y, x = grid()
    view = View(27.5, 19.5, 56, 1.0)
    slope = 2 * np.tan(np.radians(70) / 2) / 56
    ray = np.sqrt(1 + (slope * (x - 27.5)) ** 2 + (slope * (y - 19.5)) ** 2)
    # A face that runs away steeply: planar makes no line, and as a distance it is the same face.
    depth = 1 / (0.2 - 0.0038 * (y + x) / 2)
    near = disc(radius=6)
    depth[near] *= 0.8
    planar = filters.aov_lines(depth)
    distance = filters.aov_lines(depth * ray, projection="distance", field_of_view=70.0, view=view)
    np.testing.assert_allclose(distance.lines, planar.lines, atol=1e-3)
    # Without perspective Z is affine, and 1/Z is not.
    flat = 3.0 + 8.0 * x
    assert filters.aov_lines(flat, projection="orthographic").lines.min() == 1
    assert filters.aov_lines(np.where(near, 2.0, flat), projection="orthographic").lines.min() < 0.1
    assert inked(filters.aov_lines(np.where(near, 2.0, np.inf), projection="orthographic")) == {"outline"}


def test_a_wrong_sample_beside_an_object_does_not_move_its_line():
    depth, ids = disc_before_wall()
    clean = filters.aov_lines(depth, id=ids)
    wrong = depth.copy()
    wrong[18, 14], wrong[8, 24] = depth[18, 4], depth[2, 24]  # two pixels of the disc show the wall behind
    again = filters.aov_lines(wrong, id=ids)
    np.testing.assert_allclose(again.lines, clean.lines, atol=0.02)


def test_coverage_puts_a_line_where_the_edge_is():
    _, x = grid()
    edge = 20.3  # a vertical edge: the object to the left covers 0.8 of column 20
    ids = np.where(x < 20.5, 2, 0).astype(np.uint32)
    coverage = np.where(x == 20, 0.8, 1.0)
    made = filters.aov_lines(id=ids, coverage=coverage)
    assert made.distance[20, 20] == pytest.approx(edge - 20, abs=0.01)
    assert made.distance[20, 20] < filters.aov_lines(id=ids).distance[20, 20] - 0.15
    nothing = filters.aov_lines(id=np.full(ids.shape, 2, np.uint32), coverage=(x < 20).astype(np.float32))
    assert inked(nothing) == {"outline"}


# ---------------------------------------------------------------------- properties


def test_flips_and_transposes_of_passes_give_those_of_lines():
    depth, ids = disc_before_wall()
    normals = roof(60)[0]
    made = filters.aov_lines(depth, normals, ids)
    for change in (np.flipud, np.fliplr, lambda picture: np.swapaxes(picture, 0, 1)):
        turned = filters.aov_lines(*(np.ascontiguousarray(change(each)) for each in (depth, normals, ids)))
        for kind in ("lines", *KINDS):
            one, other = change(getattr(made, kind)), getattr(turned, kind)
            assert (np.abs(one - other) > 1e-3).mean() < 0.001, kind


def test_the_number_of_threads_changes_no_bit(each_thread_count):
    depth, ids = disc_before_wall(120, 70)
    normals = roof(60, 120, 70)[0]
    one, *others = each_thread_count(lambda: filters.aov_lines(depth, normals, ids, material=ids // 2))
    for other in others:
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)


def test_what_is_asked_for_changes_no_line():
    depth, ids = disc_before_wall()
    whole, lines = filters.aov_lines(depth, id=ids), filters.aov_lines(depth, id=ids, outputs=("lines",))
    np.testing.assert_array_equal(whole.lines, lines.lines)
    assert lines.distance is lines.strength is lines.flow is None


@pytest.mark.parametrize("size", [(1, 1), (1, 30), (30, 1), (2, 2), (5, 17), (16, 33)])
def test_pictures_of_any_size(size):
    rng = np.random.default_rng(3)
    depth, normals = rng.random(size) + 1, rng.random((*size, 3)) - 0.5
    ids = rng.integers(0, 3, size).astype(np.uint32)
    made = filters.aov_lines(depth, normals, ids, rng.random(size), ids)
    for each in made:
        assert each.shape[:2] == size
        assert np.isfinite(each).all()
    assert (ink_of(made) >= 0).all()
    np.testing.assert_allclose(made.lines, 1 - ink_of(made).max(axis=0), atol=1e-6)


def test_pictures_with_nothing_on_them():
    for far in (1e10, 65504.0, np.inf, np.nan, 0.0):
        made = filters.aov_lines(np.full((9, 20), far), np.zeros((9, 20, 3)), np.zeros((9, 20), np.uint32))
        assert made.lines.min() == 1
        assert (made.distance == 10).all()
        np.testing.assert_array_equal(made.flow, np.broadcast_to(np.float32([1, 0]), (9, 20, 2)))


def test_numbers_that_are_not_finite_are_background_and_no_normals():
    depth, ids = disc_before_wall()
    depth[30:, 40:], depth[:5, :5] = np.nan, -np.inf
    normals = roof(60)[0]
    normals[10:20, 10:20] = np.nan
    made = filters.aov_lines(depth, normals, ids)
    assert all(np.isfinite(each).all() for each in made)


# ---------------------------------------------------------------------- what is refused


def test_what_is_refused():
    depth, _ = disc_before_wall()
    with pytest.raises(ArgumentError, match="at least one of depth, normal and id"):
        filters.aov_lines()
    with pytest.raises(ArgumentError, match=r"normal: expected the size of the picture, 56x40, found 20x9"):
        filters.aov_lines(depth, np.zeros((9, 20, 3)))
    with pytest.raises(ArgumentError, match=r"id: expected the size of the picture, 56x40, found 20x9"):
        filters.aov_lines(depth, id=np.zeros((9, 20), np.uint32))
    with pytest.raises(ArgumentError, match="id: expected whole numbers, found dtype float"):
        filters.aov_lines(id=depth)
    with pytest.raises(ArgumentError, match="coverage: needs the id pass"):
        filters.aov_lines(depth, coverage=depth)
    with pytest.raises(ArgumentError, match="negative numbers alone"):
        filters.aov_lines(-depth)
    with pytest.raises(ArgumentError, match="depth: expected a picture of at least one pixel"):
        filters.aov_lines(np.zeros((0, 5)))
    for name, value in {"width": 9, "depth_step": 0, "crease_angle": 0, "sigma_m": -1, "field_of_view": 180}.items():
        with pytest.raises(ArgumentError, match=f"{name}: expected a number"):
            filters.aov_lines(depth, **{name: value})
    with pytest.raises(ArgumentError, match=r"outputs: expected one of .* found 'outlines'"):
        filters.aov_lines(depth, outputs=("outlines",))
    with pytest.raises(ArgumentError, match="projection: expected one of"):
        filters.aov_lines(depth, projection="fisheye")
