"""In an evaluation code values, decoded pixels and alpha are computed once, and together where that is possible."""

import gc
import weakref

import numpy as np
import pytest

from flowabs_nodes.color import codes as color_codes
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.encodings import Encodings, remember_encodings
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.finishing.deferred import with_operation
from flowabs_nodes.finishing.operations import OnRows, Quantize
from flowabs_nodes.image import Image
from tests.engine.fakes import picture


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

    count(color_codes, "encoded", "encoded")
    count(color_codes.Codes, "decode", "decoded")
    return seen


@pytest.fixture
def encodings():
    with remember_encodings() as encodings:
        yield encodings


def test_code_values_are_made_once(encodings, conversions):
    image = picture()
    assert image.encoded("lab") is image.encoded("lab")
    assert image.encoded_mono("lab") is image.encoded_mono("lab", ground=1.0)
    assert image.with_codes(image.encoded("lab"), "lab").encoded("lab") is image.encoded("lab")
    assert conversions == ["encoded", "encoded"]


def test_pixels_are_decoded_once_and_alpha_is_shared_with_what_a_filter_makes(encodings, conversions):
    image = picture(alpha=True)
    alpha = image.alpha
    smooth = image.with_codes(image.encoded("lab"), "lab")
    assert smooth.alpha is alpha
    assert smooth.pixels is smooth.pixels
    assert smooth.encoded_mono("lab") is smooth.encoded_mono("lab")
    np.testing.assert_array_equal(smooth.encoded_mono("lab"), smooth.encoded("lab")[..., 0])
    assert conversions == ["encoded", "decoded"]


def test_outside_of_an_evaluation_each_call_computes_afresh(conversions):
    image = picture()
    np.testing.assert_array_equal(image.encoded("lab"), image.encoded("lab"))
    smooth = image.with_codes(image.encoded("lab"), "lab")
    np.testing.assert_array_equal(smooth.pixels, smooth.pixels)
    assert conversions == ["encoded"] * 3 + ["decoded"] * 2


def test_an_evaluation_inside_another_shares_nothing_with_it(encodings):
    image = picture()
    outer = image.encoded("lab")
    with remember_encodings():
        assert image.encoded("lab") is not outer
    assert image.encoded("lab") is outer


def test_lightness_and_colour_are_made_together_where_both_are_expected(encodings, conversions):
    image, plain = picture(), picture()
    encodings.expect(image, frozenset({"lab"}))
    np.testing.assert_array_equal(image.encoded_mono("lab"), plain.encoded_mono("lab"))
    del conversions[:]
    np.testing.assert_array_equal(image.encoded("lab"), plain.encoded("lab"))
    assert conversions == ["encoded"], "that of the plain one"


def test_who_asks_last_gets_code_values_that_nobody_else_holds(encodings, conversions):
    image = picture()
    codes, mono = image.encoded("lab"), image.encoded_mono("lab")
    encodings.keep(image, False)
    assert image.encoded("lab") is codes
    encodings.keep(image, True)
    assert image.encoded_mono("lab") is not mono
    assert conversions == ["encoded"] * 3


def test_what_is_made_of_an_image_goes_with_it_and_with_the_evaluation():
    gc.disable()
    try:
        with remember_encodings():
            image, kept = picture(alpha=True), picture(alpha=True, seed=2)
            smooth = kept.with_codes(kept.encoded("lab"), "lab")
            arrays = [image.encoded("lab"), image.encoded_mono("lab"), image.alpha]
            others = [kept.encoded("acescct"), smooth.pixels]
            gone, later = ([weakref.ref(each.base) for each in held] for held in (arrays, others))
            del arrays, others
            assert all(each() is not None for each in gone + later)
            del image
            assert all(each() is None for each in gone)
        assert all(each() is None for each in later)
    finally:
        gc.enable()


def test_a_source_that_decodes_to_another_dtype_or_shape_is_refused():
    class Doubles:
        shape = (6, 8, 3)
        codes = Codes(picture().encoded(), "lab")

        def decode(self, colorspace):
            return np.zeros(self.shape)

    image = picture().with_deferred(Doubles())
    with pytest.raises(FlowabsError, match=r"decoded as float64 .*, expected float32 \(6, 8, 3\)"):
        _ = image.pixels


def test_encodings_can_be_asked_directly():
    image = Image.from_array(np.ones((2, 2)))
    assert Encodings().pixels(image) is image.pixels
    assert Encodings().alpha(image) is None


def test_pixels_that_are_let_go_are_decoded_again_and_those_that_are_kept_are_not(encodings, conversions):
    image = picture()
    smooth = image.with_codes(image.encoded("lab"), "lab")
    pixels = smooth.pixels
    encodings.let_go(smooth)
    assert smooth.pixels is pixels, "kept until the engine says otherwise"
    encodings.keep(smooth, False)
    before = weakref.ref(pixels)
    expected = pixels.copy()
    encodings.let_go(smooth)
    del pixels
    gc.collect()
    assert before() is None
    np.testing.assert_array_equal(smooth.pixels, expected)
    assert conversions == ["encoded", "decoded", "decoded"]
    encodings.let_go(picture())  # of which nothing has been computed


def test_who_encodes_for_the_last_time_leaves_no_decoded_pixels(encodings, conversions):
    image = picture()
    smooth = image.with_codes(image.encoded("lab"), "lab")
    encodings.keep(smooth, False)
    codes = smooth.encoded("acescct")
    assert smooth.pixels is not None
    assert conversions == ["encoded", "decoded", "encoded", "decoded"], "the pixels were not held"
    other = image.with_codes(image.encoded("lab"), "lab")
    np.testing.assert_array_equal(other.encoded("acescct"), codes)
    assert other.pixels is not None
    assert conversions[-2:] == ["decoded", "encoded"], "kept: decoded once"


def darken(rows, first_row):
    """Halve the light of rows, in place, the less the farther down they are."""
    rows[..., :3] *= (1 - 0.5 / (1 + np.arange(first_row, first_row + len(rows), dtype=np.float32)))[:, None, None]


DARKEN = OnRows(darken)


@pytest.mark.parametrize("alpha", [False, True], ids=["opaque", "alpha"])
@pytest.mark.parametrize("operations", [(), (DARKEN,), (Quantize(4, 0.3), DARKEN, Quantize(6, 0.0))])
def test_pixels_that_nobody_keeps_are_encoded_in_bands_to_the_same_bits(encodings, operations, alpha, monkeypatch):
    monkeypatch.setattr("flowabs_nodes.encodings._AT_ONCE", 64)
    image = picture(width=40, height=70, alpha=alpha)

    def made():
        smooth = image.with_codes(image.encoded("lab"), "lab")
        for operation in operations:
            smooth = with_operation(smooth, operation)
        return smooth

    for space in ("lab", "acescct"):
        whole = made()
        for ask in (
            lambda it, space=space: it.encoded(space, ground=0.5),
            lambda it, space=space: it.encoded_mono(space, ground=0.5),
            lambda it, space=space: it.encoded_opponent(space, ground=0.5),
        ):
            apart = made()
            encodings.keep(apart, False)
            np.testing.assert_array_equal(ask(apart), ask(whole))


def test_pixels_that_are_not_finite_are_counted_in_the_whole_picture(encodings):
    image = picture(width=40, height=70)

    def spoil(rows, first_row):
        rows[0] = np.inf

    spoilt = with_operation(image.with_codes(image.encoded("lab"), "lab"), spoil, "spoiler")
    with pytest.raises(ArgumentError) as whole:
        spoilt.encoded("acescct")
    encodings.keep(spoilt, False)
    with pytest.raises(ArgumentError) as apart:
        spoilt.encoded("acescct")
    assert "Inf" in str(whole.value)
    assert str(apart.value) == str(whole.value)


def test_opponent_channels_are_lightness_and_what_red_and_blue_have_beside_it(encodings):
    image = picture(alpha=True)
    codes, mono = image.encoded("acescct", ground=1.0), image.encoded_mono("acescct", ground=1.0)
    opponent = image.encoded_opponent("acescct", ground=1.0)
    np.testing.assert_array_equal(opponent, np.stack([mono, codes[..., 0] - mono, codes[..., 2] - mono], 2))
    assert image.encoded_opponent("lab", ground=1.0) is image.encoded("lab", ground=1.0)
