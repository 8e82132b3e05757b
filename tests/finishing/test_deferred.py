"""Operations that are deferred until pixels are asked for."""

from __future__ import annotations

import numpy as np

from flowabs_nodes import color
from flowabs_nodes.color.codes import Codes
from flowabs_nodes.finishing.deferred import Deferred, then
from flowabs_nodes.finishing.fused import finish
from flowabs_nodes.finishing.operations import Ink, Quantize

REC709 = color.space("lin_rec709")
RGB = np.random.default_rng(2).random((3, 20, 3), np.float32)
CODES = Codes(color.encode(RGB), "lab")
QUANTIZE = Quantize(4, 0.0)
INK = Ink(np.linspace(0, 1, 60, dtype=np.float32).reshape(3, 20), (0.0, 0.5, 0.0), 1.0)


def test_operations_queue_up_behind_the_code_values() -> None:
    first = then(CODES, QUANTIZE)
    assert first == Deferred(CODES, (QUANTIZE,))
    second = then(first, INK)
    assert second is not None
    assert second.codes is CODES
    assert second.operations == (QUANTIZE, INK)
    assert first.operations == (QUANTIZE,), "the first is what it was"


def test_decoding_does_them_all() -> None:
    deferred = then(then(CODES, QUANTIZE), INK)
    assert deferred is not None
    np.testing.assert_array_equal(deferred.decode(REC709), finish(CODES, (QUANTIZE, INK), REC709))


def test_what_does_not_fit_into_one_pass_is_refused() -> None:
    assert then(then(CODES, INK), QUANTIZE) is None
    assert then(then(CODES, INK), INK) is None
    assert then(Codes(color.encode(RGB, "acescct"), "acescct"), QUANTIZE) is None


def test_an_image_with_pixels_has_nothing_to_defer() -> None:
    assert then(None, INK) is None
