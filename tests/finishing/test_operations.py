"""Which deferred operations one kernel can do."""

from __future__ import annotations

import numpy as np
import pytest

from flowabs_nodes.finishing.operations import Ink, Operation, Quantize, fused_together, split

QUANTIZE = Quantize(5, 0.0)
INK = Ink(np.zeros((2, 3), np.float32), (0.0, 0.0, 0.0), 1.0)


@pytest.mark.parametrize(
    ("operations", "in_lab", "in_acescct"),
    [
        ((QUANTIZE,), True, False),  # ACEScct has no L* at hand
        ((INK,), True, True),
        ((QUANTIZE, INK), True, False),
        ((INK, QUANTIZE), False, False),  # ink would be quantised with the picture
        ((QUANTIZE, QUANTIZE), False, False),
        ((INK, INK), False, False),
        ((QUANTIZE, INK, INK), False, False),
        ((), False, False),  # nothing to do but to decode
    ],
)
def test_what_one_kernel_does(operations: tuple[Operation, ...], in_lab: bool, in_acescct: bool) -> None:
    assert fused_together("lab", operations) is in_lab
    assert fused_together("acescct", operations) is in_acescct


def test_split_finds_each_operation() -> None:
    assert split((QUANTIZE, INK)) == (QUANTIZE, INK)
    assert split((INK,)) == (None, INK)
    assert split((QUANTIZE,)) == (QUANTIZE, None)
