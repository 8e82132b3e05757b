"""Which deferred operations one kernel can do while it decodes."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes.finishing.operations import Ink, OnRows, Operation, Quantize, fused_with_decoding

QUANTIZE = Quantize(5, 0.0)
INK = Ink(np.zeros((2, 3), np.float32), (0.0, 0.0, 0.0), 1.0)
OWN = OnRows(lambda rows, first_row: None)


@pytest.mark.parametrize(
    ("operations", "in_lab", "in_acescct"),
    [
        ((QUANTIZE,), (QUANTIZE, None), (None, None)),  # ACEScct has no L* at hand
        ((INK,), (None, INK), (None, INK)),
        ((QUANTIZE, INK), (QUANTIZE, INK), (None, None)),
        ((INK, QUANTIZE), (None, INK), (None, INK)),  # ink would be quantised with the picture
        ((QUANTIZE, QUANTIZE), (QUANTIZE, None), (None, None)),
        ((INK, INK), (None, INK), (None, INK)),
        ((QUANTIZE, INK, INK), (QUANTIZE, INK), (None, None)),
        ((QUANTIZE, OWN, INK), (QUANTIZE, None), (None, None)),
        ((OWN, QUANTIZE, INK), (None, None), (None, None)),
        ((), (None, None), (None, None)),  # nothing to do but to decode
    ],
)
def test_the_first_that_one_kernel_does(
    operations: tuple[Operation, ...],
    in_lab: tuple[Quantize | None, Ink | None],
    in_acescct: tuple[Quantize | None, Ink | None],
) -> None:
    assert fused_with_decoding("lab", operations) == in_lab
    assert fused_with_decoding("acescct", operations) == in_acescct
