"""An image is a value; its pixels and code values, and what is done to them in one go."""

import copy

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.color import codes as encodings
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.finishing.deferred import Deferred
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context
from tests.engine.fakes import picture
from tests.naive import quantize as naive

LINES = np.linspace(0, 1, 48, dtype=np.float32).reshape(6, 8)


def with_holes(seed=1):
    """Return premultiplied RGBA with alpha 0, between 0 and 1, and 1."""
    image = picture(alpha=True, seed=seed)
    pixels = image.pixels.copy()
    pixels[..., 3] = np.clip(3 * pixels[..., 3] - 1, 0, 1)
    pixels[..., :3] *= pixels[..., 3:]
    pixels[0, 0] = (0.5, 0.25, 0.125, 0)  # light without cover
    return image.with_pixels(pixels)


def smoothed(image, space):
    """Return the image as a filter leaves it: as code values, here darker ones."""
    return image.with_codes(image.encoded(space) * np.float32(0.9), space)


def node(name, image, **inputs_and_params):
    inputs = {name: value for name, value in inputs_and_params.items() if isinstance(value, Image)}
    params = {name: value for name, value in inputs_and_params.items() if name not in inputs}
    return call_node(catalogue()[name], Context(), {"image": image, **inputs}, params)["image"]


@pytest.fixture
def conversions(monkeypatch):
    """Record the names of conversions, in order."""
    seen = []

    def count(home, name, said):
        original = getattr(home, name)

        def counted(*args, **kwargs):
            seen.append(said)
            return original(*args, **kwargs)

        monkeypatch.setattr(home, name, counted)

    count(encodings, "encoded", "encoded")
    count(encodings.Codes, "decode", "decoded")
    count(Deferred, "decode", "decoded")
    return seen


@pytest.mark.parametrize("space", color.SPACES)
def test_without_alpha_code_values_are_the_pixels(space):
    image = picture()
    np.testing.assert_array_equal(image.encoded(space), color.encode(image.pixels, space))
    np.testing.assert_array_equal(image.encoded_mono(space, ground=1.0), color.encode_mono(image.pixels, space))
    np.testing.assert_array_equal(
        smoothed(image, space).pixels, color.decode(smoothed(image, space).encoded(space), space)
    )


@pytest.mark.parametrize("space", color.SPACES)
def test_with_alpha_filtering_sees_the_colour_and_analysis_the_ground_behind(space):
    image = with_holes()
    rgb, a = image.pixels[..., :3], image.pixels[..., 3:]
    bare = np.divide(rgb, a, out=np.zeros_like(rgb), where=a > 0)
    np.testing.assert_allclose(image.encoded(space), color.encode(bare, space), atol=1e-4)
    np.testing.assert_allclose(image.encoded_mono(space), color.encode_mono(bare, space), atol=1e-4)
    over = rgb + (1 - a) * np.float32(0.5)
    np.testing.assert_allclose(image.encoded(space, ground=0.5), color.encode(over, space), atol=1e-4)
    np.testing.assert_allclose(image.encoded_mono(space, ground=0.5), color.encode_mono(over, space), atol=1e-4)


@pytest.mark.parametrize("space", color.SPACES)
def test_code_values_come_back_under_the_same_alpha(space):
    image = with_holes()
    result = smoothed(image, space)
    rgb, a = color.decode(result.encoded(space), space), image.pixels[..., 3:]
    np.testing.assert_array_equal(result.pixels[..., 3:], a)
    np.testing.assert_allclose(result.pixels[..., :3], np.where(a == 0, image.pixels[..., :3], rgb * a), atol=1e-6)
    again = smoothed(result, space)
    np.testing.assert_array_equal(again.pixels[0, 0], image.pixels[0, 0])


def test_alpha_of_one_everywhere_stays_a_channel_and_is_no_alpha():
    pixels = picture(alpha=True).pixels.copy()
    pixels[..., 3] = 1
    image = Image.from_array(pixels)
    assert image.alpha is None
    result = smoothed(image, "lab")
    assert result.alpha is None
    assert result.channels == ("R", "G", "B", "A")
    assert (result.pixels[..., 3] == 1).all()


@pytest.mark.parametrize("softness", [0.0, 0.7])
@pytest.mark.parametrize("make", [picture, with_holes])
def test_quantise_and_ink_on_the_way_are_those_of_pixels(make, softness, conversions):
    image = smoothed(make(), "lab")
    lines = image.with_pixels(LINES, "matte")
    flat = node("quantize", image, levels=5, softness=softness)
    comp = node("composite", flat, lines=lines, ink=(0.1, 0.2, 0.3), opacity=0.6)
    assert conversions.count("decoded") == 0
    found = comp.pixels
    assert conversions.count("decoded") == 1

    plain = image.with_pixels(image.pixels)  # nothing left of code values
    assert plain.deferred is None
    expected = node("quantize", plain, levels=5, softness=softness)
    np.testing.assert_allclose(flat.pixels, expected.pixels, rtol=1e-4, atol=1e-5)
    expected = node("composite", expected, lines=lines, ink=(0.1, 0.2, 0.3), opacity=0.6)
    np.testing.assert_allclose(found, expected.pixels, rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(comp.encoded("lab"), expected.encoded("lab"), atol=1e-2)


def test_quantise_is_a_gain_on_light():
    image = picture()
    lstar = color.encode_mono(image.pixels).astype(float) / 2.55
    gain = np.vectorize(naive.gain)(lstar, 5)
    np.testing.assert_allclose(node("quantize", image, levels=5).pixels, image.pixels * gain[..., None], rtol=1e-5)


def test_nothing_writes_on_an_image():
    mine = np.ones((2, 3, 4), np.float32)
    mine[0] = 0.5
    image = Image(mine, Image.from_array(mine).spec, "color")
    for array in (image.pixels, image.alpha, image.encoded(), image.encoded_mono(), smoothed(image, "lab").pixels):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 7
    assert mine.flags.writeable, "the caller's array stays what it is"
    assert np.shares_memory(mine, image.pixels)
    for name in ("type", "colorspace", "origin", "pixels", "spec", "anything"):
        with pytest.raises(AttributeError):
            setattr(image, name, None)
    with pytest.raises(AttributeError):
        del image.type
    spec = image.spec
    spec.x = 7
    assert image.data_window.x == 0


def test_the_header_that_an_image_is_made_of_may_change_afterwards():
    spec = Image.from_array(np.ones((2, 3))).spec
    image = Image(np.ones((2, 3, 1), np.float32), spec, "mono")
    spec.x, spec.channelnames = 5, ("Z",)
    assert (image.data_window.x, image.channels) == (0, ("Y",))


def test_a_copy_is_another_image_of_the_same_pixels():
    image = with_holes()
    for original in (image, smoothed(image, "lab")):
        copied = copy.copy(original)
        assert copied is not original
        assert copied.deferred is original.deferred
        assert np.shares_memory(copied.pixels, original.pixels) is (original is image)
        np.testing.assert_array_equal(copied.pixels, original.pixels)


def test_decoded_holds_pixels_alone():
    image = smoothed(picture(), "lab")
    plain = image.decoded()
    assert plain.deferred is None
    np.testing.assert_array_equal(plain.pixels, image.pixels)
    assert plain.decoded() is plain


def test_a_picture_that_is_not_finite_is_refused_when_it_is_looked_at():
    pixels = picture().pixels.copy()
    pixels[2, 3, 1] = np.nan
    image = Image.from_array(pixels)
    for look in (image.encoded, image.encoded_mono, lambda: node("quantize", image)):
        with pytest.raises(Exception, match="found 1 that are NaN or Inf"):
            look()


# ---------------------------------------------------------------------- as a NumPy array


def test_numpy_takes_an_image_as_its_pixels():
    image = picture(alpha=True)
    assert np.asarray(image) is image.pixels
    assert not np.asarray(image).flags.writeable
    own = np.array(image)
    own[...] = 0
    assert image.pixels.any()
    assert np.asarray(image, np.float64).dtype == np.float64
    np.testing.assert_array_equal(image + np.zeros(1, np.float32), image.pixels)
    np.testing.assert_allclose(np.mean(image), image.pixels.mean())


def test_numpy_gets_no_copy_where_it_wants_none():
    image = picture()
    assert image.__array__(copy=False) is image.pixels
    assert image.__array__(np.float32, copy=False) is image.pixels
    assert image.__array__(np.float64, copy=True).flags.writeable
    with pytest.raises(ValueError, match="needs a copy"):
        image.__array__(np.float16, copy=False)


def test_numpy_gets_the_pixels_that_a_filter_left_as_code_values():
    image = picture()
    np.testing.assert_array_equal(np.asarray(smoothed(image, "lab")), smoothed(image, "lab").pixels)
