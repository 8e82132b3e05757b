"""Operations that are deferred until pixels are asked for."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.array_types import Array
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.finishing.deferred import Deferred, with_operation
from flowabs_nodes.finishing.finish import finish
from flowabs_nodes.finishing.operations import Ink, OnRows, Quantize
from flowabs_nodes.image import Image

REC709 = color.space("lin_rec709")
RGB = np.random.default_rng(2).random((3, 20, 3), np.float32)
PLAIN = Image.from_array(RGB)
SMOOTH = PLAIN.with_codes(PLAIN.encoded(), "lab")
QUANTIZE = Quantize(4, 0.0)
INK = Ink(np.linspace(0, 1, 60, dtype=np.float32).reshape(3, 20), (0.0, 0.5, 0.0), 1.0)


def halved(rows: Array, first_row: int) -> None:
    rows *= np.float32(0.5)


def test_operations_queue_up_behind_the_code_values() -> None:
    first = with_operation(SMOOTH, QUANTIZE)
    second = with_operation(with_operation(first, halved, "half"), INK)
    assert SMOOTH.deferred is not None
    assert first.deferred == Deferred(SMOOTH.deferred.codes, (QUANTIZE,))
    assert second.deferred == Deferred(SMOOTH.deferred.codes, (QUANTIZE, OnRows(halved, "half"), INK))


def test_decoding_does_them_all() -> None:
    image = with_operation(with_operation(SMOOTH, QUANTIZE), INK)
    assert SMOOTH.deferred is not None
    np.testing.assert_array_equal(image.pixels, finish(SMOOTH.deferred.codes, (QUANTIZE, INK), REC709))


def test_an_image_with_pixels_is_changed_at_once() -> None:
    image = with_operation(PLAIN, halved)
    assert image.deferred is None
    np.testing.assert_array_equal(image.pixels, RGB * np.float32(0.5))
    np.testing.assert_array_equal(PLAIN.pixels, RGB)


def test_only_colours_have_operations() -> None:
    with pytest.raises(ArgumentError, match="color images, this one is mono"):
        with_operation(Image.from_array(RGB[..., 0]), halved)
