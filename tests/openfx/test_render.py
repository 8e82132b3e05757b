"""Frames through the plug-in: the bits of Python, whatever way the host holds its pictures."""

import os
import threading

import numpy as np
import pytest

import flowabs_nodes as fa
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.graph.shipped import shipped
from tests.openfx.conftest import PANEL, SOFT, instance_of, picture
from tests.openfx.host import FAILED, FILTER, GENERAL, IMAGE_FORMAT
from tests.openfx.images import Held, Layout


def expected(graph, source, output, *, frame=1, scale=1.0, colorspace=None, alpha=None, **values):
    """Return what Python makes of a picture, as RGBA in the same colour space and with the same alpha."""
    plate = fa.Image.from_array(source, colorspace, alpha=alpha)
    made = fa.load_graph(graph).run(frame, {"plate": plate}, values, [output], scale=scale)[output]
    return made.to_array(colorspace=colorspace, alpha=alpha, channels="RGBA")


@pytest.mark.parametrize("context", [FILTER, GENERAL])
@pytest.mark.parametrize("alpha", [False, True])
def test_the_bits_are_pythons(host, context, alpha):
    source = picture(alpha=alpha)
    instance = instance_of(host, "panel", source, context=context)
    instance.set(stops=1.5, which=1, turned="R,B")
    assert np.array_equal(instance.render(), expected(PANEL, source, "pick", stops=1.5, which=1, turned="R,B"))
    instance.destroy()


def test_every_knob_arrives(host):
    source = picture()
    instance = instance_of(host, "panel", source)
    instance.set(output=2, ink=[0.1, 0.2, 0.9], adaptive=False)
    assert np.array_equal(instance.render(), expected(PANEL, source, "inked", ink=[0.1, 0.2, 0.9]))
    instance.destroy()


@pytest.mark.parametrize(
    "layout",
    [
        Layout(negative=True),
        Layout(gap=32),
        Layout(negative=True, gap=16, origin=(-5, 9)),
        Layout(origin=(3, -2)),
        Layout(depth="OfxBitDepthHalf"),
        Layout(depth="OfxBitDepthHalf", negative=True, gap=6, origin=(1, 1)),
    ],
    ids=str,
)
def test_however_the_pixels_lie(host, layout):
    source = picture(seed=3)
    if layout.depth == "OfxBitDepthHalf":
        source = source.astype(np.float16).astype(np.float32)
    instance = instance_of(host, "panel", source, layout=layout)
    instance.set(stops=0.5)
    wanted = expected(PANEL, source, "pick", stops=0.5)
    assert np.array_equal(instance.render(), wanted.astype(instance.clips["Output"].held.pixels.dtype))
    instance.destroy()


@pytest.mark.parametrize("window", [(0, 0, 16, 4), (3, 5, 9, 7), (15, 11, 16, 12)])
def test_a_render_window_is_a_part_of_the_whole_frames_result(host, window):
    source = picture(seed=4)
    instance = instance_of(host, "soft", source)
    instance.set(sigma=2.0)
    output = instance.clips["Output"].held
    rows, columns = output.rows_of(window)
    got = instance.render(window=window)[rows, columns]
    assert np.array_equal(got, expected(SOFT, source, "soft", sigma=2.0)[rows, columns])
    instance.destroy()


def test_a_window_beyond_the_source_is_black_and_transparent_there(host):
    source = picture(8, 8)
    target = Held(np.full((12, 16, 4), 7, np.float32), Layout(origin=(-4, -2)))
    instance = instance_of(host, "panel", source, output=target)
    got = instance.render()
    assert np.array_equal(got[2:10, 4:12], source)
    got[2:10, 4:12] = 0
    assert not got.any()
    instance.destroy()


@pytest.mark.parametrize("scale", [0.5, 0.25])
@pytest.mark.parametrize(("graph", "output"), [("soft", "soft"), ("flat", "flat")])
def test_a_proxy_has_the_bits_of_scale(host, graph, output, scale):
    whole = fa.Image.from_array(picture(96, 128, seed=5))
    small = np.ascontiguousarray(scale_image(whole, scale).pixels)
    instance = instance_of(host, graph, small)
    instance.project(128, 96)
    got = instance.render(scale=scale)
    document = SOFT if graph == "soft" else graph
    made = fa.load_graph(document).run(1, {"plate": whole}, outputs=[output], scale=scale)[output]
    assert np.array_equal(got, made.to_array(channels="RGBA"))
    instance.destroy()


def test_lengths_follow_the_projects_format_not_the_box_of_an_element(host):
    source = picture(40, 40, seed=6)
    instance = instance_of(host, "flat", source, layout=Layout(origin=(30, 50)))
    instance.project(160, 120)
    plate = fa.Image.from_array(source, data_window=(30, 30, 40, 40), display_window=(0, 0, 160, 120))
    made = fa.load_graph("flat").run(1, {"plate": plate}, outputs=["flat"])["flat"]
    assert np.array_equal(instance.render(), made.to_array(channels="RGBA"))
    alone = expected("flat", source, "flat")
    assert not np.array_equal(alone, made.to_array(channels="RGBA"))
    instance.destroy()


@pytest.mark.parametrize(
    ("choice", "name"), [(1, "ACEScg"), (2, "ACEScct"), (3, "sRGB"), (4, "DaVinci Intermediate WideGamut")]
)
def test_pixels_in_another_colour_space_go_in_and_come_out(host, choice, name):
    source = picture(seed=7) * 0.5 + 0.2
    source[..., 3] = 1
    instance = instance_of(host, "panel", source)
    instance.set(colorspace=choice, stops=1.0)
    assert np.array_equal(
        instance.render(), expected(PANEL, source, "pick", colorspace=name, alpha="premultiplied", stops=1.0)
    )
    instance.set(colorspace=5, colorspace_name=name)
    assert np.array_equal(
        instance.render(), expected(PANEL, source, "pick", colorspace=name, alpha="premultiplied", stops=1.0)
    )
    instance.destroy()


def test_alpha_as_the_clip_has_it(host):
    source = picture(seed=8, alpha=True)
    source[..., :3] /= source[..., 3:]
    instance = instance_of(host, "soft", source, layout=Layout(premultiplication="OfxImageAlphaUnPremultiplied"))
    instance.set(sigma=1.5)
    assert np.array_equal(instance.render(), expected(SOFT, source, "soft", alpha="straight", sigma=1.5))
    instance.destroy()
    opaque = picture(seed=8)
    opaque[..., 3] = 0.25  # means nothing
    instance = instance_of(host, "soft", opaque, layout=Layout(premultiplication="OfxImageOpaque"))
    instance.set(sigma=1.5)
    got = instance.render()
    assert np.array_equal(got[..., :3], expected(SOFT, opaque[..., :3].copy(), "soft", sigma=1.5)[..., :3])
    assert (got[..., 3] == 1).all()
    instance.destroy()


@pytest.mark.parametrize("mask_channels", [1, 4])
def test_mask_and_mix_lay_the_result_over_the_source(host, mask_channels):
    source, mask = picture(seed=9), picture(seed=10)[..., :mask_channels]
    mask[..., -1] = np.linspace(-0.5, 1.5, 12 * 16).reshape(12, 16)
    mask[0, :, -1] = np.nan
    instance = instance_of(host, "panel", source)
    instance.set(stops=2.0, mix=0.75)
    instance.clips["Mask"].connect(Held(mask))
    result = expected(PANEL, source, "pick", stops=2.0)
    amount = 0.75 * np.clip(np.nan_to_num(mask[..., -1:].astype(np.float64)), 0, 1)
    wanted = (source + (result.astype(np.float64) - source) * amount).astype(np.float32)
    assert np.array_equal(instance.render(), wanted)
    instance.destroy()


def test_half_pixels_are_mixed_as_numpy_rounds_them(host):
    rng = np.random.default_rng(11)
    bits = rng.integers(0, 0x7C00, (12, 16, 4)).astype(np.uint16)  # every finite number, the smallest too
    source = bits.view(np.float16).astype(np.float32)
    source[..., 3] = 1
    instance = instance_of(host, "panel", source, layout=Layout(depth="OfxBitDepthHalf"))
    instance.set(stops=-1.0, mix=0.5)
    result = expected(PANEL, source, "pick", stops=-1.0).astype(np.float16).astype(np.float64)
    wanted = (source + (result - source) * 0.5).astype(np.float32).astype(np.float16)
    assert np.array_equal(instance.render(), wanted)
    instance.destroy()


def test_another_plate_and_a_depth_come_from_clips_of_their_own(host):
    source, other, far = picture(seed=12), picture(seed=13, alpha=True), picture(seed=14) * 100
    instance = instance_of(host, "panel", source)
    instance.clips["other"].connect(Held(other))
    instance.clips["depth"].connect(Held(far))
    instance.set(output=1, how=1)
    merged = fa.load_graph(PANEL).run(
        1, {"plate": fa.Image.from_array(source), "other": fa.Image.from_array(other)}, {"how": "multiply"}, ["both"]
    )
    assert np.array_equal(instance.render(), merged["both"].to_array(channels="RGBA"))
    instance.set(output=3)
    assert np.array_equal(instance.render()[..., :3], np.repeat(far[..., :1], 3, axis=2))
    instance.clips["depth"].connect(Held(far[..., :1].copy()))
    assert np.array_equal(instance.render()[..., :3], np.repeat(far[..., :1], 3, axis=2))
    instance.destroy()


def test_a_clip_that_is_missing_is_named(host):
    instance = instance_of(host, "panel", picture())
    for output, clip in ((1, "other"), (3, "depth")):
        instance.set(output=output)
        instance.render(expect=FAILED)
        assert instance.message[1].startswith(f"connect the clip {clip}, or set its file in the graph: node '{clip}': ")
    instance.destroy()


def test_what_moves_is_read_at_the_time_of_the_frame(host):
    source = picture(seed=15)
    instance = instance_of(host, "panel", source)
    instance.set(stops=lambda time: time / 10)
    assert np.array_equal(
        instance.render(time=6.0), expected(PANEL, source, "pick", frame=6, stops=0.6)
    )  # curve of the graph too
    instance.set(moving=2.0)
    assert np.array_equal(instance.render(time=6.0), expected(PANEL, source, "pick", frame=6, stops=0.6, moving=2.0))
    instance.destroy()


def test_without_a_source_the_frame_is_black_and_transparent(host):
    instance = instance_of(host, "panel", None)
    assert not instance.render().any()
    assert instance.message is None
    instance.destroy()


def test_one_pixel(host):
    source = picture(1, 1)
    for name in ("panel", "soft", "flat"):
        instance = instance_of(host, name, source)
        assert instance.render().shape == (1, 1, 4)
        instance.destroy()


@pytest.mark.parametrize("depth", ["OfxBitDepthByte", "OfxBitDepthShort"])
def test_other_depths_are_refused_with_a_reason(host, depth):
    instance = instance_of(host, "panel", picture(), layout=Layout(depth=depth))
    instance.render(expect=IMAGE_FORMAT)
    kind, text = instance.message
    assert kind == "OfxMessageError"
    assert depth in text
    assert "floats of 32 or 16 bits" in text
    instance.destroy()


def test_an_image_that_is_none_is_refused(host):
    instance = instance_of(host, "panel", picture())
    for lie, words in (
        ({"OfxImagePropData": [None]}, "an image without pixels"),
        ({"OfxImageEffectPropComponents": ["OfxImageComponentYUVA"]}, "the host gave OfxImageComponentYUVA"),
        ({"OfxImagePropBounds": []}, "an image without pixels"),
    ):
        instance.clips["Source"].lies = lie
        instance.render(expect=IMAGE_FORMAT)
        assert words in instance.message[1]
    instance.clips["Source"].lies = {}
    instance.render()
    assert instance.message is None
    instance.destroy()


def test_a_part_of_the_picture_is_filtered_and_warned_of(host):
    instance = instance_of(host, "panel", picture(), layout=Layout(whole=(0, 0, 16, 40)))
    instance.render()
    assert instance.message[0] == "OfxMessageWarning"
    instance.destroy()


def test_two_instances_at_once_do_not_disturb_each_other(host):
    sources = [picture(64, 64, seed=seed) for seed in range(4)]
    instances = [instance_of(host, "soft", source) for source in sources]
    # the checks of the host know one action at a time: each thread calls the plug-in itself
    wanted = [expected(SOFT, source, "soft") for source in sources]
    lock, got = threading.Lock(), {}

    def work(place):
        for _ in range(3):
            pixels = instances[place].render(expect=None).copy()
            with lock:
                got[place] = pixels

    threads = [threading.Thread(target=work, args=(place,)) for place in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(got[place], wanted[place]) for place in range(4))
    # an action that begins while another one is at work is what the host cannot tell from a wrong order
    host.faults[:] = [
        fault for fault in host.faults if "given back" not in fault and "outside of a render" not in fault
    ]
    for instance in instances:
        instance.destroy()
    assert host.taken == host.given_back


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in shipped() if name not in ("toon", "outline")])
def test_every_shipped_graph_has_the_bits_of_python(host, name):
    source = np.concatenate([picture(60, 40, seed=16), picture(60, 40, seed=17) * 0.2], axis=1)
    source[..., 3] = 1
    params = host.plugin(name).contexts[FILTER].params
    outputs = params["output"].props.values["OfxParamPropChoiceOption"] if "output" in params else ["one"]
    from flowabs_nodes.engine.plan import output_names

    for place, output in enumerate(output_names(fa.load_graph(name), None)):
        instance = instance_of(host, name, source)
        if "output" in params:
            instance.set(output=place)
        assert np.array_equal(instance.render(), expected(name, source, output)), (name, output)
        instance.destroy()
    assert len(outputs) == place + 1


def passes():
    """Return the passes of a render as hosts have them, RGBA, by the clip's name: a near box before a wall."""
    y, x = np.indices((40, 60))
    near = (abs(x - 30) < 12) & (abs(y - 20) < 9)
    planes = {name: np.zeros((40, 60, 4), np.float32) for name in ("normal", "ids", "ids_coverage", "materials")}
    planes["depth"] = np.where(near, 3, 9)[..., None] * np.ones(4, np.float32)
    planes["normal"][..., 2] = planes["ids_coverage"][..., 0] = planes["materials"][..., 0] = 1
    planes["ids"][..., 0] = 1 + near
    return {name: np.ascontiguousarray(pixels, np.float32) for name, pixels in planes.items()}


@pytest.mark.slow
def test_a_graph_for_renders_takes_passes_as_clips(host):
    """Outputs are those of Python; a clip that is missing is named."""
    source = picture(40, 60, seed=18)
    source[..., 3] = 1
    instance = instance_of(host, "outline", source, context=GENERAL)
    instance.render(expect=FAILED)
    assert instance.message[1].startswith("connect the clip depth, or set its file in the graph: node 'depth': ")
    clips = passes()
    for name, pixels in clips.items():
        instance.clips[name].connect(Held(pixels))
    kinds = {"depth": "depth", "normal": "normal", "ids": "id", "ids_coverage": "mono", "materials": "id"}
    given = {"plate": fa.Image.from_array(source)}
    for name, kind in kinds.items():
        pixels = clips[name][..., : 3 if kind == "normal" else 1]
        pixels = pixels.astype(np.uint32) if kind == "id" else pixels
        given[name.replace("_", ".")] = fa.Image.from_array(pixels, type=kind)
    made = fa.load_graph("outline").run(1, given, outputs=["comp"])["comp"].to_array(channels="RGBA")
    found = instance.render()
    assert np.array_equal(found, made)
    assert np.abs(found - source).max() > 0.05, "there is ink"
    instance.destroy()


def test_nothing_is_left_in_shared_memory(host):
    left = [name for name in os.listdir("/dev/shm") if name.startswith(f"flowabs-{os.getpid()}-")]
    assert left == []
