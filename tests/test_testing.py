"""The compliance suite must let a good node pass, and name what is wrong with each bad one."""

import dataclasses

import numpy as np
import pytest

from flowabs_nodes import filters
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image, Window
from flowabs_nodes.nodes.declare import Node, Param, Port
from flowabs_nodes.nodes.regions import pixelwise, within
from flowabs_nodes.testing import ComplianceError, check_node, compliance_checks
from flowabs_nodes.testing.parameters import alternatives
from tests.engine.windows import MEAN, asking, run_mean


def run_gain(context, image, *, gain, mode, keep):
    pixels = image.pixels * np.float32(gain if mode == "times" else 1 / gain)
    return image.with_pixels(np.where(image.pixels < 0, image.pixels, pixels) if keep else pixels)


GAIN = Node(
    type="gain",
    version=1,
    help="A gain.",
    inputs=(Port("image", "color|mono|matte", "The picture."),),
    outputs=(Port("image", "=image", "The result."),),
    params=(
        Param.float("gain", 1.0, min=0.1, max=10, soft=(0.5, 2), help="How much."),
        Param.enum("mode", "times", ("times", "over"), help="Which way."),
        Param.bool("keep", False, help="Leave values below zero."),
    ),
    run=run_gain,
)


@pytest.mark.parametrize("check", compliance_checks(GAIN), ids=lambda check: check.name)
def test_a_good_node_passes(check):
    check()


def with_run(run, **fields):
    return dataclasses.replace(GAIN, run=run, **fields)


def without_params(run, **fields):
    return with_run(lambda context, image, **_: run(context, image), params=(), **fields)


def changes_input(context, image):
    image.pixels[0, 0] = 7
    return image


def changes_shared_codes(context, image):
    if image.type == "color":
        image.encoded("lab")[...] = 0
    return image


def spreads_nan(context, image):
    return image.with_pixels(image.pixels - image.pixels.mean())


def forgets(context, image):
    return image.with_pixels(image.pixels + np.random.default_rng().random())


def flickers(context, image):
    return image.with_pixels(image.pixels * np.float32(context.frame % 2))


def breaks_on_one_pixel(context, image):
    return image.with_pixels(image.pixels / np.ptp(np.arange(image.pixels.shape[0]), keepdims=True))


def moves(context, image):
    return Image.from_array(image.pixels)


def crashes_on_nan(context, image):
    if not np.isfinite(image.pixels).all():
        raise IndexError("out of range")
    return image.with_pixels(image.pixels * 2)


def blurred_in(region):
    """Return a node that blurs over three pixels to each side and declares this region."""
    return without_params(lambda context, image: image.with_pixels(filters.blur(image.pixels, 1.0)), region=region)


def conditional(switch, values):
    """Return GAIN, whose gain says that it does something beside some values of another parameter only."""
    gain = dataclasses.replace(GAIN.params[0], enabled_when={switch: values})
    return dataclasses.replace(GAIN, params=(gain, *GAIN.params[1:]))


MATTE = Port("image", "matte", "A matte.")

BAD = [
    ("is_documented", dataclasses.replace(GAIN, help="")),
    ("is_documented", dataclasses.replace(GAIN, inputs=(Port("image", "color", ""),))),
    ("is_documented", dataclasses.replace(GAIN, params=(Param.float("gain", 1.0, min=0, soft=(-1, 1), help="."),))),
    ("leaves_inputs_alone", without_params(changes_input)),
    ("leaves_inputs_alone", without_params(changes_shared_codes)),
    ("survives_nan_and_inf", without_params(spreads_nan)),
    ("survives_nan_and_inf", without_params(crashes_on_nan)),
    ("gives_the_same_again", without_params(forgets)),
    ("owes_to_the_frame_what_it_says", without_params(flickers)),
    ("owes_to_the_frame_what_it_says", without_params(flickers, moment=lambda params, frame: frame // 2)),
    ("owes_to_the_frame_what_it_says", with_run(run_gain, moment=lambda params, frame: frame)),
    ("takes_small_pictures", without_params(breaks_on_one_pixel)),
    ("runs_with_defaults", without_params(moves)),
    ("mode_changes_the_picture", with_run(lambda context, image, *, gain, mode, keep: image)),
    ("works_on_a_region", blurred_in(pixelwise("image"))),
    ("works_on_a_region", blurred_in(within(lambda params: 2, "image"))),
    ("works_on_a_region", blurred_in(lambda params, window: {"picture": window})),
    ("works_on_a_region", blurred_in(lambda params, window: {"image": Window(10**6, 0, 1, 1)})),
    ("works_on_a_region", without_params(spreads_nan, region=pixelwise("image"))),
    ("gain_does_nothing_where_disabled", conditional("mode", ("times",))),
    ("is_documented", dataclasses.replace(GAIN, label=" Gain")),
    (
        "keep_changes_the_picture",
        with_run(lambda context, image, **params: run_gain(context, image, **params | {"keep": 0})),
    ),
    ("runs_with_defaults", without_params(lambda context, image: image.with_pixels(image.pixels + 2), inputs=(MATTE,))),
]


@pytest.mark.parametrize(("name", "node"), BAD)
def test_a_bad_node_is_caught(name, node):
    with np.errstate(all="ignore"), pytest.raises(ComplianceError, match=name):
        check_node(node)


def test_a_node_may_refuse_bad_pixels():
    def run(context, image, **_):
        if not np.isfinite(image.pixels).all():
            raise ArgumentError("finite pixels are expected")
        return image.with_pixels(image.pixels - image.pixels.mean())

    checks = {check.name: check for check in compliance_checks(with_run(run))}
    checks["survives_nan_and_inf"]()


@pytest.mark.parametrize("region", [within(lambda params: 3, "image"), lambda params, window: {}])
def test_a_region_may_be_exact_or_larger(region):
    {check.name: check for check in compliance_checks(blurred_in(region))}["works_on_a_region"]()


def test_a_condition_that_holds_is_fine_and_enables_what_it_needs():
    def run(context, image, *, gain, mode, keep):
        return run_gain(context, image, gain=gain if mode == "over" else 2.0, mode=mode, keep=keep)

    node = dataclasses.replace(conditional("mode", ("over",)), run=run)
    checks = {check.name: check for check in compliance_checks(node)}
    for name in ("gain_does_nothing_where_disabled", "gain_changes_the_key", "gain_changes_the_picture"):
        checks[name]()


def test_a_parameter_that_matters_only_beside_others_is_found():
    def run(context, image, *, gain, mode, keep):
        return image.with_pixels(image.pixels * 2) if gain == 0.5 and mode == "over" and keep else image

    checks = {check.name: check for check in compliance_checks(with_run(run))}
    checks["keep_changes_the_picture"]()


def test_a_parameter_out_of_the_key_is_exempt_but_must_stay_out():
    quiet = dataclasses.replace(GAIN.params[1], in_key=False)
    node = dataclasses.replace(GAIN, params=(GAIN.params[0], quiet, GAIN.params[2]))
    names = {check.name: check for check in compliance_checks(node)}
    assert "mode_changes_the_picture" not in names
    names["mode_changes_the_key"]()


@pytest.mark.parametrize(
    ("param", "some"),
    [
        (Param.float("x", 1.0, min=0, max=10, soft=(0, 5), help="."), [0.0, 5.0, 10.0]),
        (Param.float("x", None, nullable=True, help="."), [1, 0]),
        (Param.int("x", 3, min=1, help="."), [1, 6]),
        (Param.enum("x", "a", ("a", "b"), help="."), ["b"]),
        (Param.color("x", (0, 0, 0), help="."), [(1.0, 0.5, 0.25)]),
        (Param.custom("x", "max", schema={}, parse=lambda v: None if v in ("max", 16) else "no", help="."), [16.0]),
    ],
)
def test_values_to_try(param, some):
    found = list(alternatives(param))
    assert found[: len(some)] == some
    assert param.default not in found
    assert all(param.problem(value) is None for value in found)


# ---------------------------------------------------------------------- nodes that read other frames


@pytest.mark.parametrize("check", compliance_checks(MEAN), ids=lambda check: check.name)
def test_a_node_that_reads_other_frames_passes(check):
    check()


def test_flows_and_several_inputs_may_be_read_on_other_frames_too():
    def run(context, image, flow, *, radius):
        turned = flow[0].with_pixels(np.mean([each.pixels[..., ::-1] for each in flow.values()], axis=0))
        return {"image": run_mean(context, image, radius=radius), "flow": turned}

    node = dataclasses.replace(
        MEAN,
        inputs=(*MEAN.inputs, Port("flow", "flow", "A flow.", optional=False)),
        outputs=(*MEAN.outputs, Port("flow", "flow", "Turned.")),
        run=run,
        frames=lambda params: {"image": range(-params["radius"], params["radius"] + 1), "flow": (0, -1)},
    )
    check_node(node)


def needs_all_frames(context, image, *, radius):
    return image[0].with_pixels(image[radius].pixels - image[0].pixels)


def remembers(context, image, *, radius, last=[None]):  # noqa: B006 - the fault that is to be found
    before, last[0] = last[0], image[0].pixels
    return image[0].with_pixels(image[0].pixels if before is None else before)


@pytest.mark.parametrize(
    ("name", "node"),
    [
        ("asks_for_frames_by_the_rules", asking({"image": (1, 2)})),
        ("asks_for_frames_by_the_rules", asking(lambda params: {"image": range(-2 * params["radius"], 1)})),
        ("takes_windows_that_are_cut", asking(MEAN.frames, needs_all_frames)),
        ("gives_the_same_alone_in_a_run_and_in_another_order", asking(MEAN.frames, remembers)),
        ("radius_changes_the_picture", asking(MEAN.frames, lambda context, image, *, radius: image[0])),
    ],
)
def test_a_bad_node_that_reads_other_frames_is_caught(name, node):
    with np.errstate(all="ignore"), pytest.raises(ComplianceError, match=name):
        check_node(node)
