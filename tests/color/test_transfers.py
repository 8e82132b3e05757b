"""Transfer functions are those of colour-science, and their inverses are inverse."""

from __future__ import annotations

import colour
import numpy as np
import pytest

from flowabs_nodes.color.transfers import HLG_WHITE, PQ_WHITE, SRGB, Hlg, Parametric, Power, Pq, Sampled
from tests.color.profiles import RAMP

EACH = [Power(2.2), Power(1.0), SRGB, Pq(), Hlg(), Sampled((0.0, 0.1, 0.1, 0.5, 1.0)), Parametric(2.0, 0.9, 0.1)]


@pytest.mark.parametrize("transfer", [Power(2.2), Power(1.0), SRGB, Pq(), Hlg(), Sampled((0.0, 0.1, 0.5, 1.0))])
def test_there_and_back(transfer) -> None:
    np.testing.assert_allclose(transfer.codes(transfer.linear(RAMP)), RAMP, atol=1e-6)


@pytest.mark.parametrize("transfer", EACH)
def test_any_finite_number_stays_finite(transfer) -> None:
    numbers = np.array([-1e3, -0.5, 0, 1e-9, 0.5, 1, 1.5, 10])
    assert np.isfinite(transfer.linear(np.minimum(numbers, 1.5))).all()
    assert np.isfinite(transfer.codes(numbers)).all()


def test_srgb() -> None:
    np.testing.assert_allclose(SRGB.linear(RAMP), colour.models.eotf_sRGB(RAMP), atol=1e-12)


def test_pq_has_203_nits_at_1() -> None:
    np.testing.assert_allclose(Pq().linear(RAMP) * PQ_WHITE, colour.models.eotf_ST2084(RAMP), rtol=1e-6, atol=1e-9)
    assert Pq().codes(np.array([1.0]))[0] == pytest.approx(0.58, abs=2e-3)  # ITU-R BT.2408


def test_hlg_has_its_white_at_1() -> None:
    scene = colour.models.oetf_inverse_ARIBSTDB67(RAMP, r=0.5)  # the standard's of BT.2100 times 12
    white = colour.models.oetf_inverse_ARIBSTDB67(HLG_WHITE, r=0.5)
    np.testing.assert_allclose(Hlg().linear(RAMP), scene / white, atol=1e-6)
    assert Hlg().linear(np.array([HLG_WHITE]))[0] == pytest.approx(1)
