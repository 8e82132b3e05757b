import dataclasses

import numpy as np
import pytest

from flowabs_nodes.engine.call_node import call_node, call_sink
from flowabs_nodes.engine.error_boundary import InternalError
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.image import Image, Origin, Window
from flowabs_nodes.nodes.declare import Context, Node, Port
from tests.engine.fakes import ADD, IMAGE, SPLIT, picture


def matte(values, like):
    full = np.broadcast_to(np.asarray(values, np.float32), (like.data_window.height, like.data_window.width))
    return like.with_pixels(full.copy(), "matte")


def changed(declaration, run, **fields):
    return dataclasses.replace(declaration, run=run, **fields)


def test_runs_with_defaults():
    image = picture()
    result = call_node(ADD, Context(), {"image": image}, {})["image"]
    np.testing.assert_array_equal(result.pixels, image.pixels + np.float32(1))
    assert (result.data_window, result.display_window) == (image.data_window, image.display_window)
    assert result.spec.get("owner") == "somebody"


def test_only_what_is_wanted_comes_back():
    assert set(call_node(SPLIT, Context(wanted=frozenset({"mono"})), {"image": picture()}, {})) == {"mono"}
    assert set(call_node(SPLIT, Context(), {"image": picture()}, {})) == {"matte", "mono"}


@pytest.mark.parametrize("kind", ["mono", "matte"])
def test_an_input_is_widened_to_what_the_port_takes(kind):
    image = picture()
    grey = image.with_pixels(image.pixels[..., 0], kind)
    color_only = changed(ADD, ADD.run, inputs=(Port("image", "color", "."),))
    result = call_node(color_only, Context(), {"image": grey}, {})["image"]
    assert result.channels == ("R", "G", "B")
    np.testing.assert_array_equal(result.pixels[..., 2], grey.pixels[..., 0] + np.float32(1))


def test_optional_inputs_that_are_not_connected_are_none():
    seen = {}

    def run(context, image, other, *, amount):
        seen["other"] = other
        return image

    call_node(
        changed(ADD, run, inputs=(IMAGE, Port("other", "mono", ".", optional=True))),
        Context(),
        {"image": picture()},
        {},
    )
    assert seen == {"other": None}


# ---------------------------------------------------------------------- mask and mix


@pytest.mark.parametrize("alpha", [False, True])
def test_result_goes_over_input_by_mask_times_mix(alpha):
    image = picture(alpha=alpha)
    mask = matte(np.linspace(0, 1, 8), image)
    result = call_node(ADD, Context(), {"image": image, "mask": mask}, {"mix": 0.5})["image"]
    expected = image.pixels + 0.5 * mask.pixels
    np.testing.assert_allclose(result.pixels, expected, atol=1e-6)  # alpha too


def test_full_mix_is_the_result_itself_and_none_is_a_copy_of_the_input():
    image, kept = picture(), {}

    def run(context, image, *, amount):
        kept["result"] = image.with_pixels(image.pixels * 2)
        return kept["result"]

    node = changed(ADD, run)
    assert call_node(node, Context(), {"image": image}, {"mix": 1})["image"] is kept["result"]
    kept.clear()
    none = call_node(node, Context(), {"image": image}, {"mix": 0})["image"]
    assert none is not image
    assert none.pixels is image.pixels
    assert not kept, "a node whose result nobody sees does not run"


def test_mask_of_one_and_zero_change_no_bit():
    image = picture()
    step = np.zeros(8)
    step[4:] = 1
    result = call_node(ADD, Context(), {"image": image, "mask": matte(step, image)}, {"amount": 0.3})["image"]
    np.testing.assert_array_equal(result.pixels[:, :4], image.pixels[:, :4])
    np.testing.assert_array_equal(result.pixels[:, 4:], image.pixels[:, 4:] + np.float32(0.3))


def test_a_mask_on_another_window_is_zero_outside_it():
    image = picture()
    x, y, width, height = image.data_window
    mask = matte(1, image).on_window(Window(x + 2, y, width, height))
    result = call_node(ADD, Context(), {"image": image, "mask": mask}, {})["image"]
    np.testing.assert_array_equal(result.pixels[:, :2], image.pixels[:, :2])
    np.testing.assert_array_equal(result.pixels[:, 2:], image.pixels[:, 2:] + np.float32(1))


@pytest.mark.parametrize(("width", "height"), [(16, 12), (64, 48), (24, 32), (32, 12), (31, 24)])
def test_a_mask_of_another_size_is_refused_with_both_sizes_and_the_cure(width, height):
    mask = Image.from_array(np.ones((height, width)), type="matte")
    with pytest.raises(
        FlowabsError, match=f"'mask' is of a picture of {width}x{height}, but input 'image' of 32x24"
    ) as failure:
        call_node(ADD, Context(frame=7, node="add"), {"image": picture(), "mask": mask}, {})
    assert (failure.value.code, failure.value.node, failure.value.frame) == ("window-mismatch", "add", 7)
    assert "resize the mask to 32x24" in failure.value.hint


def test_a_mask_of_all_of_a_cropped_picture_is_cut():
    image = picture()
    mask = Image.from_array(np.ones((24, 32)), type="matte")
    result = call_node(ADD, Context(), {"image": image, "mask": mask}, {})["image"]
    assert result.data_window == image.data_window


def test_a_mask_with_the_pixels_of_the_picture_may_have_another_display_window():
    image = picture()
    spec = matte(1, image).spec
    spec.full_width, spec.full_height = 8, 6
    mask = Image(matte(1, image).pixels, spec, "matte")
    result = call_node(ADD, Context(), {"image": image, "mask": mask}, {})["image"]
    np.testing.assert_array_equal(result.pixels, image.pixels + np.float32(1))


def test_further_color_outputs_are_multiplied_by_mask_and_mix():
    def run(context, image, *, amount):
        ink = np.ones((*image.pixels.shape[:2], 4), np.float32)
        return {"image": image, "ink": image.with_pixels(ink, "color"), "other": matte(1, image)}

    outputs = (ADD.outputs[0], Port("ink", "color", "."), Port("other", "matte", "."))
    image = picture()
    found = call_node(
        changed(ADD, run, outputs=outputs), Context(), {"image": image, "mask": matte(0.5, image)}, {"mix": 0.5}
    )
    assert (found["ink"].pixels == 0.25).all()
    assert (found["other"].pixels == 1).all()
    found = call_node(changed(ADD, run, outputs=outputs), Context(), {"image": image}, {"mix": 0})
    assert found["image"] is not image
    assert found["image"].pixels is image.pixels
    assert (found["ink"].pixels == 0).all()


# ---------------------------------------------------------------------- windows and metadata


def test_inputs_on_different_windows_are_refused_and_both_named():
    node = changed(ADD, ADD.run, inputs=(IMAGE, Port("flow", "flow", ".")))
    flow = Image.from_array(np.ones((6, 8, 2), np.float32))
    with pytest.raises(
        FlowabsError, match=r"'flow' has the data window 8x6\+0\+0, but input 'image' has 8x6\+3-2"
    ) as failure:
        call_node(node, Context(frame=7, node="lines"), {"image": picture(), "flow": flow}, {})
    assert (failure.value.code, failure.value.node, failure.value.frame) == ("window-mismatch", "lines", 7)
    assert failure.value.hint == ""
    inputs = {
        name: Image(image.pixels, image.spec, image.type, origin=Origin(f"/shots/{name}.exr"))
        for name, image in (("image", picture()), ("flow", flow))
    }
    with pytest.raises(FlowabsError, match=r"flow is of flow.exr, image is of image.exr"):
        call_node(node, Context(frame=7, node="lines"), inputs, {})


def test_layers_are_brought_to_the_image_window():
    seen = {}

    def run(context, image, *, amount, **layers):
        seen.update(layers)
        return {"picture": 1}

    sink = changed(ADD, run, outputs=(), extra_inputs=Port("*", "any", "A layer."))
    image = picture()
    depth = Image.from_array(np.ones((2, 2)), type="data", channels=("Z",))
    assert call_sink(sink, Context(), {"image": image, "depth": depth}, {}) == {"picture": 1}
    assert seen["depth"].data_window == image.data_window
    assert seen["depth"].pixels.sum() == 0  # image begins at x = 3


def test_a_layer_cannot_be_called_like_a_parameter():
    sink = changed(ADD, ADD.run, outputs=(), extra_inputs=Port("*", "any", "A layer."))
    with pytest.raises(FlowabsError, match="cannot be called 'amount'"):
        call_sink(sink, Context(), {"image": picture(), "amount": picture()}, {})


def test_metadata_and_origin_that_a_node_loses_are_put_back():
    def run(context, image, *, amount):
        spec = image.spec
        spec.erase_attribute("owner")
        spec.attribute("comment", "new")
        return Image(image.pixels * 2, spec, "color", colorspace=image.colorspace)

    plain = picture()
    image = Image(plain.pixels, plain.spec, "color", origin=Origin("plate.exr"))
    result = call_node(changed(ADD, run), Context(), {"image": image}, {})["image"]
    assert (result.spec.get("owner"), result.spec.get("comment")) == ("somebody", "new")
    assert result.origin == image.origin


def test_metadata_is_put_back_without_decoding():
    def run(context, image, *, amount):
        plain = Image(image.pixels, Image.from_array(image.pixels).spec, "color")
        result = plain.with_codes(image.encoded(), "lab")
        spec = image.spec
        spec.erase_attribute("owner")
        return Image(result.deferred, spec, "color")

    result = call_node(changed(ADD, run), Context(), {"image": picture()}, {})["image"]
    assert result.spec.get("owner") == "somebody"
    assert result.deferred is not None


# ---------------------------------------------------------------------- what may not be


def a_flow():
    return Image.from_array(np.ones((2, 2, 2)))


@pytest.mark.parametrize(
    ("inputs", "params", "code", "words"),
    [
        ({}, {}, "missing-input", "'image' is not connected"),
        ({"imag": picture}, {}, "unknown-input", "did you mean 'image'"),
        ({"image": a_flow}, {}, "wrong-type", "takes color, not flow"),
        ({"image": picture}, {"amout": 1}, "unknown-param", "did you mean 'amount'"),
        ({"image": picture}, {"amount": "1"}, "wrong-type", "parameter amount"),
        ({"image": picture}, {"amount": 101}, "out-of-range", "from -100 to 100"),
        ({"image": picture}, {"mix": 1.5}, "out-of-range", "parameter mix"),
    ],
)
def test_wrong_inputs_and_parameters(inputs, params, code, words):
    images = {name: make() for name, make in inputs.items()}
    with pytest.raises(FlowabsError, match=words) as failure:
        call_node(ADD, Context(node="sum"), images, params)
    assert (failure.value.code, failure.value.node) == (code, "sum")


def test_an_input_that_needs_another_one():
    """As a known edge's strength needs its flow."""
    ports = (IMAGE, Port("strength", "mono", ".", optional=True, beside="along"), Port("along", "flow", ".", True))
    pair = changed(ADD, lambda context, image, strength, along, **params: image, inputs=ports)
    image = picture()
    call_node(pair, Context(), {"image": image}, {})
    with pytest.raises(FlowabsError, match="input 'strength' needs 'along' too") as caught:
        call_node(pair, Context(), {"image": image, "strength": image.with_pixels(image.pixels[..., 0], "mono")}, {})
    assert caught.value.code == "missing-input"


@pytest.mark.parametrize(
    ("run", "words"),
    [
        (lambda context, image, **_: None, "the node returned NoneType"),
        (lambda context, image, **_: {"imgae": image}, "the node returned NoneType"),
        (
            lambda context, image, **_: image.pixels.astype(np.float64),
            r"output 'image' of add@1 must be an Image, the node returned an array of float64 \(6, 8, 3\)",
        ),
        (
            lambda context, image, **_: image.with_pixels(image.pixels[..., 0], "mono"),
            "must be color, the node returned mono",
        ),
        (lambda context, image, **_: Image.from_array(image.pixels), "windows of its input"),
        (lambda context, image, **_: image.with_pixels(image.pixels[:2]), "windows of its input"),
    ],
)
def test_wrong_outputs(run, words):
    with pytest.raises(FlowabsError, match=words) as failure:
        call_node(changed(ADD, run), Context(), {"image": picture()}, {})
    assert (failure.value.code, failure.value.node) == ("wrong-output", "add")


def test_an_unforeseen_exception_says_node_and_frame_and_keeps_its_cause():
    def run(context, image, *, amount):
        return 1 / 0

    with pytest.raises(InternalError, match="frame 12: node sum: ZeroDivisionError: division by zero") as failure:
        call_node(changed(ADD, run), Context(frame=12, node="sum"), {"image": picture()}, {})
    assert failure.value.code == "internal"
    assert isinstance(failure.value.__cause__, ZeroDivisionError)


@pytest.mark.parametrize(
    "write",
    [
        lambda image: image.pixels.fill(0),
        lambda image: np.multiply(image.encoded("lab"), 2, out=image.encoded("lab")),
        lambda image: image.encoded_mono("acescct").__setitem__(0, 0),
        lambda image: image.alpha.__setitem__((0, 0), 1),
    ],
)
def test_writing_on_an_input_is_numpy_s_own_error_with_the_node_s_name(write):
    def run(context, image, *, amount):
        write(image)
        return image

    with pytest.raises(InternalError, match=r"node tint: ValueError: .* is read-only") as failure:
        call_node(changed(ADD, run), Context(node="tint"), {"image": picture(alpha=True)}, {})
    assert isinstance(failure.value.__cause__, ValueError)


@pytest.mark.parametrize("dtype", [np.complex64, object, "U1"])
def test_pixels_that_are_no_real_numbers_are_refused_with_the_node_s_name(dtype):
    def run(context, image, *, amount):
        return image.with_pixels(np.zeros(image.pixels.shape, dtype))

    with pytest.raises(ArgumentError, match="node tint: parameter pixels: expected an array of real numbers, found"):
        call_node(changed(ADD, run), Context(node="tint"), {"image": picture()}, {})


def test_setting_an_attribute_of_an_input_is_an_error_with_the_node_s_name():
    def run(context, image, *, amount):
        image.type = "matte"
        return image

    with pytest.raises(InternalError, match="node tint: AttributeError: an Image never changes: type cannot be set"):
        call_node(changed(ADD, run), Context(node="tint"), {"image": picture()}, {})


def test_an_exception_s_many_lines_become_one():
    def run(context, image, *, amount):
        raise TypeError("first\nsecond\nthird")

    with pytest.raises(InternalError, match=r"TypeError: first$"):
        call_node(changed(ADD, run), Context(), {"image": picture()}, {})


def test_running_out_of_memory_is_said_as_such():
    def run(context, image, *, amount):
        raise MemoryError

    with pytest.raises(InternalError, match="not enough memory") as failure:
        call_node(changed(ADD, run), Context(), {"image": picture()}, {})
    assert failure.value.code == "out-of-memory"


def test_a_node_s_own_error_stays_and_gets_its_place():
    error = ArgumentError("too odd", parameter="amount")

    def run(context, image, *, amount):
        raise error

    with pytest.raises(ArgumentError) as failure:
        call_node(changed(ADD, run), Context(frame=3, node="sum"), {"image": picture()}, {})
    assert failure.value is error
    assert str(error) == "frame 3: node sum: parameter amount: too odd"


def test_stopping_is_not_caught():
    def run(context, image, *, amount):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        call_node(changed(ADD, run), Context(), {"image": picture()}, {})


def test_declarations_stay_usable_as_they_are():
    assert isinstance(ADD, Node)
    assert ADD.mixes
    assert not SPLIT.mixes


# ---------------------------------------------------------------------- ids have no mean


def other_ids(context, image):
    return image.with_pixels(np.full_like(image.pixels, 2**32 - 1))


RENAME = Node("rename", 1, ".", (Port("image", "id|mono", "."),), (Port("image", "=image", "."),), (), other_ids)
IDS = Image.from_array(np.array([[2**24 + 1, 2**24 + 3, 0, 2**31 + 1]], np.uint32), type="id")


def test_a_mask_takes_each_id_from_one_side_whole():
    mask = Image.from_array(np.array([[0.0, 0.49, 0.5, 1.0]]), type="matte")
    mixed = call_node(RENAME, Context(), {"image": IDS, "mask": mask}, {})["image"].pixels
    assert mixed.dtype == np.uint32
    np.testing.assert_array_equal(mixed[0, :, 0], [2**24 + 1, 2**24 + 3, 2**32 - 1, 2**32 - 1])


@pytest.mark.parametrize(("mix", "changed"), [(0, False), (0.3, False), (0.5, True), (1, True)])
def test_mix_takes_all_ids_from_one_side(mix, changed):
    mixed = call_node(RENAME, Context(), {"image": IDS}, {"mix": mix})["image"].pixels
    np.testing.assert_array_equal(mixed, np.full_like(IDS.pixels, 2**32 - 1) if changed else IDS.pixels)
