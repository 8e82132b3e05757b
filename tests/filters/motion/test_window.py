import numpy as np
import pytest

from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.filters import blur, motion_window
from tests.filters.motion.scenes import Scene
from tests.naive import motion_window as naive

WHOLE, FRACTIONS = Scene(), Scene(ground=(0.3, 1.7), disc=(-1.6, 0.45))
OFFSETS = range(-2, 3)
STILL, CODES = np.zeros((33, 45, 4), np.float32), np.zeros((33, 45, 3), np.float32)


def noisy(frames, sigma=6.0):
    """Return frames with noise, each its own."""
    return {
        k: frame + np.random.default_rng(k + 9).normal(0, sigma, frame.shape).astype(np.float32)
        for k, frame in frames.items()
    }


def directions(scene, offsets=OFFSETS):
    """Return noisy flows of a scene."""
    frames = noisy(scene.frames("flow", offsets), 0.1)
    return {k: frame / np.linalg.norm(frame, axis=2, keepdims=True) for k, frame in frames.items()}


def jittered(frames, by=0.2):
    """Return motion that is not quite right."""
    return noisy(frames, by)


def window(scene, what="codes", passes=("depth", "normal"), **options):
    """Return the result for a picture of a scene, with its passes."""
    images = options.pop("images", None) or noisy(scene.frames(what))
    inputs = {f"{name}s": scene.frames(name) for name in passes}
    motions = options.pop("motions", None) or scene.frames("motion")
    guides = options.pop("guides", scene.frames("code"))
    return motion_window(images, motions, guides, **inputs, **options)


def inner(array, margin=9):
    return array[margin:-margin, margin:-margin]


# ---------------------------------------------------------------------- against the naive twin


@pytest.mark.parametrize("what", ["code", "codes", "alpha", "flow"])
@pytest.mark.parametrize("passes", [(), ("depth", "normal")])
def test_is_the_naive_mean(what, passes):
    scene = FRACTIONS
    alphas = scene.frames("alpha") if what == "alpha" else None
    images = directions(scene) if what == "flow" else noisy(scene.frames("code" if what == "code" else "codes"))
    inputs = {f"{name}s": scene.frames(name) for name in passes}
    motions, guides = jittered(scene.frames("motion")), noisy(scene.frames("code"))
    found = motion_window(images, motions, guides, alphas=alphas, guide_blur=0, **inputs)
    mean, confidence = naive.motion_window(images, motions, guides, alphas=alphas, **inputs)
    assert 0.1 < confidence.mean() < 0.9
    np.testing.assert_allclose(found.confidence, confidence, atol=1e-4)
    np.testing.assert_allclose(found.mean, mean, atol=2e-3)


@pytest.mark.parametrize(
    "options",
    [
        {"reach": 4, "falloff": "box"},
        {"reach": 1, "agreement": 3.0},
        {"consistency": 0.2},
        {"consistency": 8.0, "depth_tolerance": 0.5},
        {"consistency": 8.0, "depth_tolerance": 10.0, "normal_tolerance": 60.0},
    ],
)
def test_every_parameter_is_the_naive_ones(options):
    scene, offsets = FRACTIONS, range(-4, 5)
    images, guides = noisy(scene.frames("code", offsets)), noisy(scene.frames("code", offsets), 2)
    passes = {f"{name}s": scene.frames(name, offsets) for name in ("depth", "normal")}
    motions = jittered(scene.frames("motion", offsets))
    found = motion_window(images, motions, guides, guide_blur=0, **passes, **options)
    mean, confidence = naive.motion_window(images, motions, guides, **passes, **options)
    np.testing.assert_allclose(found.confidence, confidence, atol=1e-4)
    np.testing.assert_allclose(found.mean, mean, atol=2e-3)


def test_the_guide_is_blurred_first():
    guides = noisy(FRACTIONS.frames("code"))
    blurred = {k: blur(guide, 2.0) for k, guide in guides.items()}
    one, other = window(FRACTIONS, guides=guides), window(FRACTIONS, guides=blurred, guide_blur=0)
    assert np.array_equal(one.mean, other.mean)
    assert not np.array_equal(one.mean, window(FRACTIONS, guides=guides, guide_blur=0).mean)


# ---------------------------------------------------------------------- what a mean along the motion has to do


@pytest.mark.parametrize("channels", [(), (2,), (3,)])
def test_a_picture_that_moves_by_whole_pixels_keeps_its_bits(channels):
    world = np.random.default_rng(1).uniform(0, 255, (80, 90, *channels)).astype(np.float32)
    if channels == (2,):
        world /= np.linalg.norm(world, axis=2, keepdims=True)
    images = {k: world[20 - 2 * k : 60 - 2 * k, 20 - 3 * k : 71 - 3 * k] for k in OFFSETS}
    motions = dict.fromkeys(OFFSETS, np.broadcast_to(np.float32([-3, 2, -3, 2]), (40, 51, 4)))
    found = motion_window(images, motions)
    if channels == (2,):  # a mean of tensors, turned back into a tangent
        np.testing.assert_allclose(found.mean, images[0], rtol=0, atol=2e-7)
    else:
        assert np.array_equal(found.mean, images[0])
    assert inner(found.confidence).min() == 1


def test_noise_shrinks_by_the_root_of_the_number_of_frames():
    scene = Scene(width=80, height=60, disc=(1.0, 2.0))
    still = dict.fromkeys(OFFSETS, np.zeros((60, 80, 4), np.float32))
    images = noisy(dict.fromkeys(OFFSETS, scene.frames("code")[0]))
    found = window(scene, images=images, motions=still, guides=None, passes=(), falloff="box")
    assert np.std(found.mean - scene.frames("code")[0]) == pytest.approx(6 / 5**0.5, rel=0.02)
    assert (found.confidence == 1).all()


def test_a_pixel_whose_surface_is_hidden_on_the_other_frames_keeps_its_own():
    images = noisy(WHOLE.frames("code"))
    found = window(WHOLE, images=images)
    x, y = WHOLE.coords()
    hidden = np.zeros(x.shape, bool) | True
    for k in (-1, 1):  # the ground of these pixels is behind the disc on both neighbours
        cx, cy = x + k * WHOLE.ground[0], y + k * WHOLE.ground[1]
        hidden &= np.hypot(cx - WHOLE.width / 2 - k * WHOLE.disc[0], cy - WHOLE.height / 2 - k * WHOLE.disc[1]) < 7
    hidden &= ~WHOLE.covered(0)
    assert np.array_equal(found.mean[hidden], images[0][hidden])
    assert not found.confidence[hidden].any()


def test_light_that_moves_over_a_surface_does_not_smear():
    still = dict.fromkeys(OFFSETS, np.zeros((40, 60, 4), np.float32))
    images = {k: np.full((40, 60), 200, np.float32) for k in OFFSETS}
    for k in OFFSETS:
        images[k][:, 20 + 4 * k : 36 + 4 * k] = 100  # a shadow, 4 pixels a frame
    agreed = motion_window(images, still, images)
    smeared = motion_window(images, still, None)
    error = np.abs(agreed.mean - images[0])
    assert error.mean() < 0.05 * np.abs(smeared.mean - images[0]).mean()
    assert error.max() < 25 < np.abs(smeared.mean - images[0]).max()


def test_a_mean_of_directions_has_no_sign():
    turned = [np.deg2rad([80, 100])[k % 2] for k in OFFSETS]
    flows = {
        k: np.full((20, 30, 2), (-1) ** (k // 2) * np.array([np.cos(a), np.sin(a)]), np.float32)
        for k, a in zip(OFFSETS, turned, strict=True)
    }
    found = motion_window(flows, dict.fromkeys(OFFSETS, np.zeros((20, 30, 4))), falloff="box", reach=1)
    angle = np.rad2deg(np.arctan2(*found.mean[5, 5, ::-1])) % 180
    own, others = np.exp(2j * turned[2]), np.exp(2j * turned[1])
    assert angle == pytest.approx(np.rad2deg(np.angle(own + 2 * others)) / 2 % 180, abs=1e-3)
    assert found.mean[5, 5] @ flows[0][5, 5] > 0


def test_colours_count_by_their_alpha():
    still = dict.fromkeys(OFFSETS, np.zeros((20, 30, 4), np.float32))
    images = {k: np.full((20, 30, 3), 50.0 + 10 * abs(k), np.float32) for k in OFFSETS}
    alphas = {k: np.full((20, 30), 0.0 if abs(k) == 2 else 0.5, np.float32) for k in OFFSETS}
    found = motion_window(images, still, None, alphas=alphas, falloff="box")
    np.testing.assert_allclose(found.mean, (50 + 60 + 60) / 3, rtol=1e-6)
    for none in (0.0, -1.0):  # below 0 there is no coverage either
        nothing = dict.fromkeys(OFFSETS, np.full((20, 30), none, np.float32))
        assert np.array_equal(motion_window(images, still, None, alphas=nothing).mean, images[0])


@pytest.mark.parametrize("reach", [0, 1, 2, 4])
def test_without_other_frames_nothing_changes(reach):
    image = noisy(WHOLE.frames("codes"))[0]
    found = motion_window({0: image}, {0: WHOLE.motion(0)}, reach=reach)
    assert np.array_equal(found.mean, image)
    assert not found.confidence.any()
    assert found.misfit is None


def test_reach_0_looks_at_no_other_frame():
    assert np.array_equal(
        window(WHOLE, reach=0, images=noisy(WHOLE.frames("codes"))).mean, noisy(WHOLE.frames("codes"))[0]
    )


def test_a_frame_that_any_input_lacks_ends_the_window():
    images, motions, depths = (noisy(WHOLE.frames(each)) for each in ("code", "motion", "depth"))
    del depths[1]  # so that 2 cannot be reached either
    found = motion_window(images, motions, depths=depths)
    kept = {k: depths[k] for k in (-2, -1, 0)}
    expected = motion_window({k: images[k] for k in kept}, {k: motions[k] for k in kept}, depths=kept)
    assert np.array_equal(found.mean, expected.mean)
    assert found.confidence.max() <= 0.5 + 1e-6


# ---------------------------------------------------------------------- properties


def flipped(frames, axis, signs=()):
    return {k: np.flip(frame, axis) * np.float32(signs or 1) for k, frame in frames.items()}


@pytest.mark.parametrize(("axis", "signs"), [(0, (1, -1, 1, -1)), (1, (-1, 1, -1, 1))])
def test_a_flipped_shot_is_flipped(axis, signs):
    scene = FRACTIONS
    images, motions, guides = noisy(scene.frames("codes")), scene.frames("motion"), scene.frames("code")
    depths = scene.frames("depth")
    one = motion_window(images, motions, guides, depths)
    other = motion_window(
        *(flipped(each, axis) for each in (images,)),
        flipped(motions, axis, signs),
        flipped(guides, axis),
        flipped(depths, axis),
    )
    np.testing.assert_allclose(np.flip(other.mean, axis), one.mean, atol=1e-3)
    np.testing.assert_allclose(np.flip(other.confidence, axis), one.confidence, atol=1e-4)


@pytest.mark.parametrize("shape", [(1, 1), (1, 23), (23, 1), (2, 2), (3, 40), (17, 16)])
def test_small_pictures(shape):
    height, width = shape
    scene = Scene(width=width, height=height, ground=(0.5, 0.25), disc=(0.0, 0.5), radius=2)
    images, motions, depths = (noisy(scene.frames(each), 0.5) for each in ("codes", "motion", "depth"))
    found = motion_window(images, motions, None, depths, scene.frames("normal"), consistency=4)
    mean, confidence = naive.motion_window(images, motions, None, depths, scene.frames("normal"), consistency=4)
    np.testing.assert_allclose(found.mean, mean, atol=1e-3)
    np.testing.assert_allclose(found.confidence, confidence, atol=1e-5)


def test_the_same_bits_on_any_number_of_threads(each_thread_count):
    first, *others = each_thread_count(lambda: window(FRACTIONS))
    for other in others:
        assert np.array_equal(first.mean, other.mean)
        assert np.array_equal(first.confidence, other.confidence)
        assert first.misfit == other.misfit


# ---------------------------------------------------------------------- what cannot be followed, and errors


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e10, -3e38])
def test_a_vector_that_leads_nowhere_leaves_the_pixel_to_its_frame(bad):
    images, motions = noisy(WHOLE.frames("code")), WHOLE.frames("motion")
    good = motion_window(images, motions)
    motions[0] = motions[0].copy()
    motions[0][10:14, 20:24] = bad
    found = motion_window(images, motions)
    assert np.array_equal(found.mean[10:14, 20:24], images[0][10:14, 20:24])
    assert not found.confidence[10:14, 20:24].any()
    elsewhere = np.ones(images[0].shape, bool)
    elsewhere[10:14, 20:24] = False
    assert np.array_equal(found.mean[elsewhere], good.mean[elsewhere])
    for k in (-1, 1):
        motions[k] = np.full_like(motions[k], bad)
    assert not motion_window(images, motions).confidence.any()


@pytest.mark.parametrize("far", [1e9, 1e10, np.inf, np.nan])
def test_background_is_one_depth(far):
    depths = {k: np.where(WHOLE.covered(k), np.float32(4), np.float32(1e10)) for k in OFFSETS}
    expected = window(WHOLE, passes=(), depths=depths)
    other = {k: np.where(WHOLE.covered(k), np.float32(4), np.float32(far if k else 1e10)) for k in OFFSETS}
    found = window(WHOLE, passes=(), depths=other)
    assert np.array_equal(found.mean, expected.mean)
    assert inner(found.confidence).mean() > 0.5


def test_a_normal_of_no_length_goes_with_any():
    normals = dict.fromkeys(OFFSETS, np.zeros((33, 45, 3), np.float32)) | {0: WHOLE.normal(0)}
    assert np.array_equal(window(WHOLE, passes=(), normals=normals).mean, window(WHOLE, passes=()).mean)


@pytest.mark.parametrize("shape", [(1, 1), (1, 5), (5, 1), (4, 20)])
def test_a_surface_that_turns_away_is_lost(shape):
    pictures = {k: np.full(shape, 10.0 * k, np.float32) for k in (0, 1)}
    normals = {k: np.full((*shape, 3), np.eye(3)[k], np.float32) for k in (0, 1)}
    found = motion_window(pictures, dict.fromkeys((0, 1), np.zeros((*shape, 4), np.float32)), normals=normals)
    assert not found.mean.any()
    assert not found.confidence.any()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"images": {1: np.zeros((33, 45))}}, "images: expected the own frame, 0, .*found 1"),
        ({"images": {0: np.zeros((33, 45, 4))}}, r"images: expected shape \(H, W\), .*found \(33, 45, 4\)"),
        (
            {"images": {0: np.zeros((33, 45)), 1: np.zeros((33, 44))}, "motions": {0: STILL, 1: STILL}},
            r"images: expected shape \(33, 45\), .*\(33, 44\) on frame \+1",
        ),
        ({"images": np.zeros((33, 45))}, r"images: expected pictures by their offset, .* found ndarray"),
        ({"motions": [STILL]}, r"motions: expected pictures by their offset, .* found list"),
        ({"images": {0: np.full((33, 45), np.nan)}}, "images: expected finite pixels"),
        (
            {"motions": {0: np.zeros((33, 45, 2))}},
            r"motions: expected shape \(33, 45, 4\), found \(33, 45, 2\) on frame",
        ),
        ({"guides": {0: np.zeros((30, 45))}}, "guides: expected the size of the picture, 45x33"),
        ({"guides": {0: np.full((33, 45), np.inf)}}, "guides: expected finite pixels"),
        ({"depths": {0: np.zeros((33, 45, 3))}}, "depths: expected shape"),
        ({"normals": {0: np.zeros((33, 45))}}, "normals: expected shape"),
        ({"images": {0: CODES}, "alphas": {0: np.zeros((3, 4))}}, "alphas: expected the size"),
        ({"alphas": {0: np.zeros((33, 45))}}, r"alphas: expected for code values \(H, W, 3\) alone"),
        ({"reach": 5}, "reach: expected a number .*at most 4"),
        ({"reach": 1.5}, "reach: expected a whole number"),
        ({"falloff": "boxy"}, "falloff: expected one of 'gaussian', 'box'"),
        ({"agreement": 0}, "agreement: .*greater than 0"),
        ({"guide_blur": -1}, "guide_blur"),
        ({"consistency": -1}, "consistency"),
        ({"depth_tolerance": -1}, "depth_tolerance"),
        ({"normal_tolerance": 181}, "normal_tolerance"),
    ],
)
def test_errors_name_the_argument(change, words):
    good = {"images": {0: np.zeros((33, 45))}, "motions": {0: STILL}}
    with pytest.raises(ArgumentError, match=words):
        motion_window(**good | change)
