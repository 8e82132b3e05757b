"""fa.abstraction, fa.lines and the others: one call, an array in, an array of the same kind out."""

import inspect
import logging

import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes as fa
from flowabs_nodes.color import ocio, srgb
from flowabs_nodes.errors import ArgumentError, ColorError
from flowabs_nodes.graph import GraphError
from flowabs_nodes.graph.shipped import shipped
from flowabs_nodes.image import Image

NAMES = ("abstraction", "abstraction_hdr", "bold", "flat", "inked", "lines", "pencil", "portrait")


def photo():
    """Return a small picture as screens show it, (40, 60, 3) uint8: discs on a ramp."""
    y, x = np.mgrid[0:40, 0:60]
    disc = (np.hypot(x - 20, y - 20) < 12) * 90 + (np.hypot(x - 45, y - 15) < 8) * -60
    return np.clip(np.stack([90 + x + disc, 120 + disc, 150 - y + 0.5 * disc], axis=2), 0, 255).astype(np.uint8)


RGB = photo()
LINEAR = srgb.linear((RGB / 255).astype(np.float32))


@pytest.fixture(scope="module")
def drawn():
    """Return the picture drawn by each function, as uint8."""
    return {name: getattr(fa, name)(RGB) for name in NAMES}


def test_there_is_a_function_for_each_graph_that_makes_a_picture_of_one():
    """But for those that read a render's passes, or the frames of a shot."""

    def of_one_picture(name):
        nodes = [node.declaration for node in fa.load_graph(name).nodes.values()]
        return not any(node.frames or node.type.startswith("read_") for node in nodes)

    assert {name for name in shipped() if of_one_picture(name)} - {"flow"} == set(NAMES)
    assert set(NAMES) <= set(fa.__all__)


@pytest.mark.parametrize("name", NAMES)
def test_it_is_the_graph(drawn, name):
    graph = fa.load_graph(name)
    plate = next(node for node in graph.nodes if graph.nodes[node].declaration.type == "read")
    image = next(iter(graph.run(given={plate: Image.from_array(RGB, "sRGB")}).values()))
    straight = image.pixels if image.type == "matte" else srgb.encoded(image.pixels.clip(0, 1))
    np.testing.assert_array_equal(drawn[name], np.broadcast_to(np.rint(straight * 255), RGB.shape))
    assert drawn[name].dtype == np.uint8
    assert drawn[name].std() > 5


@pytest.mark.parametrize("name", ["abstraction", "lines"])
@pytest.mark.parametrize(
    ("array", "encoding"),
    [
        (RGB * np.uint16(257), None),
        (RGB * np.uint16(257), "sRGB"),
        ((RGB / 255).astype(np.float32), "sRGB"),
        (RGB / 255, "srgb_rec709_scene"),
        (LINEAR, None),
        (LINEAR.astype(np.float64), "linear"),
        (LINEAR.astype(">f4"), "lin_rec709"),
        (np.asfortranarray(RGB), None),
    ],
)
def test_every_usual_kind_gives_the_same_picture_in_its_own_kind(drawn, name, array, encoding):
    before = array.copy()
    found = getattr(fa, name)(array, encoding=encoding)
    np.testing.assert_array_equal(array, before)
    assert (found.dtype, found.shape) == (array.dtype, array.shape)
    if name == "abstraction" and found.dtype.kind == "f" and encoding in (None, "linear", "lin_rec709"):
        found = srgb.encoded(found.astype(np.float32))
    white = np.iinfo(array.dtype).max if array.dtype.kind == "u" else 1
    np.testing.assert_allclose(found / white * 255, drawn[name], atol=1.01)


def test_half_floats_and_other_spaces_come_back_in_their_own():
    ap1 = ocio.encode_named(LINEAR, fa.color.space("lin_rec709"), "ACEScg")
    expected = fa.abstraction(LINEAR, encoding="linear")
    found = fa.abstraction(ap1, encoding="ACEScg")
    back = ocio.encode_named(found, fa.color.space("ACEScg"), "lin_rec709")
    assert np.abs(back - expected).mean() < 5e-3
    half = fa.flat(LINEAR.astype(np.float16), encoding="linear")
    assert half.dtype == np.float16
    log = ocio.encode_named(LINEAR, fa.color.space("lin_rec709"), "ARRI LogC4")
    found = ocio.linearize(fa.flat(log, encoding="ARRI LogC4"), "ARRI LogC4")
    assert np.abs(ocio.encode_named(*found, "lin_rec709") - fa.flat(LINEAR, encoding="linear")).mean() < 5e-3


def test_light_above_white_stays():
    assert fa.flat(8 * LINEAR, encoding="linear").max() > 2


def test_grey_stays_grey(drawn):
    for grey in (RGB[..., 1], RGB[..., 1:2]):
        found = fa.abstraction(grey)
        assert (found.dtype, found.shape) == (np.uint8, grey.shape)
        three = fa.abstraction(np.repeat(grey.reshape(40, 60, 1), 3, axis=2))
        np.testing.assert_allclose(found.reshape(40, 60), three[..., 1], atol=1)


def test_alpha_is_kept_and_what_it_hides_is_not_touched():
    alpha = np.full((40, 60, 1), 255, np.uint8)
    alpha[:, :8], alpha[:, 8:12] = 0, 128
    rgba = np.concatenate([RGB, alpha], axis=2)
    for name in ("abstraction", "lines"):
        found = getattr(fa, name)(rgba)
        np.testing.assert_array_equal(found[..., 3:], alpha)
        np.testing.assert_array_equal(found[:, :8], rgba[:, :8])
        assert (found[:, 12:, :3] != rgba[:, 12:, :3]).any()
    opaque = np.concatenate([RGB, np.full_like(alpha, 255)], axis=2)
    np.testing.assert_array_equal(fa.flat(opaque)[..., :3], fa.flat(RGB))


def test_alpha_of_linear_floats_is_premultiplied():
    alpha = np.full((40, 60, 1), 0.5, np.float32)
    straight = fa.flat(np.concatenate([np.float32(RGB / 255), alpha], axis=2), encoding="sRGB")
    found = fa.flat(np.concatenate([LINEAR * alpha, alpha], axis=2), encoding="linear")
    np.testing.assert_allclose(srgb.encoded(found[..., :3] / alpha), straight[..., :3], atol=2e-3)
    lines = fa.lines(np.concatenate([LINEAR * alpha, alpha], axis=2), encoding="linear")
    assert lines[..., :3].max() <= 0.5


def test_other_libraries_pictures():
    class Tensor:
        def __array__(self, dtype=None, copy=None):
            return RGB

    buf = oiio.ImageBuf(oiio.ImageSpec(60, 40, 3, "uint8"))
    buf.set_pixels(buf.roi, RGB)
    for each in (Tensor(), buf):
        np.testing.assert_array_equal(fa.flat(each), fa.flat(RGB))
    image = Image.from_array(LINEAR, "lin_ap1")
    np.testing.assert_array_equal(fa.flat(image), fa.flat(LINEAR, encoding="lin_ap1"))


def test_knobs_are_keywords_with_help():
    assert fa.lines(RGB, line_amount=1).mean() < fa.lines(RGB, line_amount=0).mean()
    for name in NAMES:
        knobs = fa.load_graph(name).interface
        function = getattr(fa, name)
        parameters = inspect.signature(function).parameters
        assert list(parameters) == ["rgb", "encoding", *knobs]
        assert all(parameters[each].default == knob.default for each, knob in knobs.items())
        assert all(knob.help in function.__doc__ for knob in knobs.values())
        assert function.__name__ == name
        assert max(map(len, function.__doc__.splitlines())) <= 140


def test_floats_that_may_be_either_are_said_to_be_taken_as_linear(caplog):
    with caplog.at_level(logging.WARNING, "flowabs"):
        fa.flat(LINEAR)
        (said,) = [each.getMessage() for each in caplog.records if "scene-linear" in each.getMessage()]
        assert said.startswith("flat: floats from 0 to 1")
        caplog.clear()
        fa.flat(LINEAR, encoding="linear")
        fa.flat(2 * LINEAR)
        fa.flat(RGB)
    assert not [each for each in caplog.records if "scene-linear" in each.getMessage()]


class Palette:
    """A Pillow image whose numbers are no colours."""

    mode = "P"

    def convert(self, mode):
        raise AssertionError


@pytest.mark.parametrize(
    ("rgb", "words"),
    [
        (RGB.astype(int), r"expected uint8, uint16 or floats, found int64 \(rgb.astype\(np.uint8\)"),
        (RGB > 100, "found bool"),
        (RGB.astype(np.float32), r"white at 1, found whole numbers up to \d+ \(divide by 255\)"),
        (257.0 * RGB, r"divide by 65535"),
        (np.moveaxis(RGB, -1, 0), r"found \(3, 40, 60\) \(channels come last"),
        (RGB[None], "one picture at a time"),
        (RGB[..., :2], r"expected \(H, W\), \(H, W, 3\) or \(H, W, 4\), found \(40, 60, 2\)"),
        (RGB[:0], r"found \(0, 60, 3\)"),
        (RGB[0, 0], "found"),
        ("photo.png", "found str"),
        (None, "found NoneType"),
        ([[1, 2], [3]], "NumPy cannot read it"),
        (Palette(), r"mode 'P' \(rgb.convert\('RGB'\)\)"),
        (oiio.ImageBuf(), "ImageBuf with flat pixels"),
        (np.full((8, 8, 3), np.nan, np.float32), "NaN"),
    ],
)
def test_what_is_no_picture_is_refused_with_the_cure(rgb, words):
    with pytest.raises(ArgumentError, match=words):
        fa.lines(rgb)


def test_wrong_keywords():
    with pytest.raises(ArgumentError, match=r"lines has no knob 'line_widht' .*'line_width'"):
        fa.lines(RGB, line_widht=2)
    with pytest.raises(GraphError, match="line_width"):
        fa.lines(RGB, line_width=99)
    with pytest.raises(ColorError, match="'sRGB'"):
        fa.lines(RGB, encoding="sRBG")
    with pytest.raises(ArgumentError, match="encoding: expected a name"):
        fa.lines(RGB, encoding=3)
