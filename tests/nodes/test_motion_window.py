"""What the node ``motion_window`` does around its filter: types, the guide, ends of a window, and what it tells."""

import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters import motion_window
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.motion_window import MOTION_WINDOW
from tests.filters.motion.scenes import Scene

SCENE = Scene()
OFFSETS = range(-2, 3)


def images(what, kind="color", scale=1.0, offsets=OFFSETS):
    """Return the scene's frames as images: "codes" as the light of a color."""
    return {
        k: Image.from_array(frame * np.float32(scale), type=kind) for k, frame in SCENE.frames(what, offsets).items()
    }


@pytest.fixture
def said():
    return []


@pytest.fixture
def run(said):
    """Return a function that runs the node and gives its outputs; what it says is in ``said``."""

    def run(inputs, **params):
        context = Context(frame=1010, note=said.append, warn=lambda text: said.append(f"warning: {text}"))
        return call_node(MOTION_WINDOW, context, inputs, params)

    return run


def passes(**more):
    return {"motion": images("motion", "motion"), **more}


def test_a_color_is_averaged_as_code_values(run, said):
    plate = images("codes", scale=1 / 255)
    depth, normal = images("depth", "depth"), images("normal", "normal")
    out = run(passes(image=plate, depth=depth, normal=normal))
    codes = {k: image.encoded("lab") for k, image in plate.items()}
    expected = motion_window(
        codes,
        SCENE.frames("motion"),
        {k: image.encoded_mono("lab") for k, image in plate.items()},
        SCENE.frames("depth"),
        SCENE.frames("normal"),
    )
    assert np.array_equal(out["image"].encoded("lab"), expected.mean)
    assert np.array_equal(out["confidence"].pixels[..., 0], expected.confidence)
    assert (out["image"].type, out["confidence"].type) == ("color", "matte")
    assert not said


def test_no_highlight_outweighs_the_rest(run):
    still = {k: Image.from_array(np.zeros((20, 30, 4)), type="motion") for k in OFFSETS}
    light = {k: Image.from_array(np.full((20, 30, 3), 100.0 if k == 1 else 0.5)) for k in OFFSETS}
    grey = {k: Image.from_array(np.full((20, 30, 3), 0.5)) for k in OFFSETS}
    alike = run({"image": light, "motion": still, "guide": grey}, falloff="box")["image"].pixels
    assert 0.5 < alike.mean() < 4 < 100 / 5  # a mean of light
    assert run({"image": light, "motion": still})["image"].pixels.mean() == pytest.approx(0.5, rel=1e-5)


def test_alpha_stays_and_colours_count_by_it(run):
    still = {k: Image.from_array(np.zeros((20, 30, 4)), type="motion") for k in OFFSETS}
    plates = {}
    for k in OFFSETS:
        alpha = np.full((20, 30, 1), 0.5 if k == 0 else 0.25)
        alpha[:5] = 0
        plates[k] = Image.from_array(np.concatenate([0.4 * alpha, 0.2 * alpha, 0.1 * alpha, alpha], axis=2))
    out = run({"image": plates, "motion": still})["image"].pixels
    np.testing.assert_allclose(out, plates[0].pixels, atol=1e-6)


@pytest.mark.parametrize("kind", ["mono", "matte"])
def test_numbers_are_averaged_as_they_are(run, kind):
    still = {k: Image.from_array(np.zeros((20, 30, 4)), type="motion") for k in OFFSETS}
    given = {k: Image.from_array(np.full((20, 30), abs(k) / 4), type=kind) for k in OFFSETS}
    out = run({"image": given, "motion": still}, falloff="box")["image"]
    assert out.type == kind
    np.testing.assert_allclose(out.pixels, (0.5 + 0.25 + 0 + 0.25 + 0.5) / 5, rtol=1e-3)


def test_a_mono_is_its_own_guide_and_a_matte_has_none(run):
    still = {k: Image.from_array(np.zeros((20, 30, 4)), type="motion") for k in OFFSETS}
    for kind, agree in (("mono", False), ("matte", True)):
        given = {
            k: Image.from_array(np.full((20, 30), float(k == 0)) * (100 if kind == "mono" else 1), type=kind)
            for k in OFFSETS
        }
        out = run({"image": given, "motion": still}, falloff="box")["image"].pixels.mean()
        assert out == pytest.approx(1 / 5 if agree else 100, rel=1e-4)
    guide = {k: Image.from_array(np.full((20, 30), 100.0 * (k == 0)), type="mono") for k in OFFSETS}
    out = run({"image": given, "motion": still, "guide": guide})["image"].pixels
    np.testing.assert_allclose(out, 1, atol=1e-6)


def test_lines_stay_between_0_and_1(run):
    random = np.random.default_rng(1)
    given = {k: Image.from_array((random.random((33, 45)) < 0.5).astype(np.float32), type="matte") for k in OFFSETS}
    for output in run(passes(image=given), consistency=50.0).values():
        assert output.pixels.min() >= 0
        assert output.pixels.max() <= 1


def test_reach_0_gives_the_very_pixels(run):
    plate = images("codes", scale=1 / 255)
    out = run({"image": plate[0], "motion": images("motion", "motion")[0]}, reach=0)
    assert np.array_equal(out["image"].pixels, plate[0].pixels)
    assert not out["confidence"].pixels.any()
    assert MOTION_WINDOW.frames({"reach": 0}) == dict.fromkeys(("image", "motion", "guide", "depth", "normal"), (0,))


# ---------------------------------------------------------------------- ends


@pytest.mark.parametrize(
    ("there", "missing"),
    [
        ((0, 1, 2), "1008, 1009"),
        ((-2, -1, 0), "1011, 1012"),
        ((-2, -1, 0, 2), "1011, 1012"),
        ((0,), "1008, 1009, 1011, 1012"),
    ],
)
def test_frames_that_are_not_there(run, said, there, missing):
    plate = images("codes", scale=1 / 255, offsets=there)
    assert run(passes(image=plate))["confidence"].pixels.max() <= 0.5
    assert said == [f"frames {missing} of its window cannot be reached: the window is smaller"]
    with pytest.raises(ArgumentError, match=rf"frames {missing} of its window cannot be reached") as failure:
        run(passes(image=plate), ends="error")
    assert (failure.value.parameter, failure.value.frame) == ("ends", 1010)


def test_a_frame_that_only_a_pass_lacks_is_not_there(run, said):
    depth = images("depth", "depth")
    del depth[2]
    run(passes(image=images("codes"), depth=depth))
    assert said == ["frame 1012 of its window cannot be reached: the window is smaller"]


# ---------------------------------------------------------------------- what it tells


def turned(signs=(1, 1, 1, 1), order=(0, 1, 2, 3)):
    """Return the motion in another convention."""
    return {
        k: Image.from_array(motion[..., list(order)] * np.float32(signs), type="motion")
        for k, motion in SCENE.frames("motion").items()
    }


@pytest.mark.parametrize(
    "motion",
    [turned((1, -1, 1, -1)), turned((-1, -1, -1, -1)), turned((-1, -1, -1, -1), (2, 3, 0, 1))],
    ids=["y down", "forward for backward", "both ways"],
)
@pytest.mark.parametrize("with_passes", [False, True])
def test_motion_of_another_convention_is_told(run, said, motion, with_passes):
    inputs = {"image": images("codes", scale=1 / 255), "motion": motion}
    if with_passes:
        inputs |= {"depth": images("depth", "depth"), "normal": images("normal", "normal")}
    run(inputs)
    assert len(said) == 2
    assert said[0].startswith("warning: frames fit worse along the motion than without it")
    assert "another convention" in said[0]
    assert said[1].startswith("along the motion the guide differs by")


def test_vectors_that_lead_nowhere_are_told(run, said):
    motion = images("motion", "motion")
    pixels = motion[0].pixels.copy()
    pixels[3, 4], pixels[5, 6, 0] = 1e10, np.nan
    motion[0] = motion[0].with_pixels(pixels)
    run({"image": images("codes", scale=1 / 255), "motion": motion})
    assert said == ["2 pixels have a motion that leads nowhere (NaN, Inf, 1e9 or more): they keep to their frame"]


def test_a_pass_of_another_size_is_refused(run):
    motion = {k: Image.from_array(np.zeros((32, 45, 4)), type="motion") for k in OFFSETS}
    with pytest.raises(FlowabsError, match=r"input 'motion' has the data window 45x32.*but input 'image' has 45x33"):
        run({"image": images("codes"), "motion": motion})
