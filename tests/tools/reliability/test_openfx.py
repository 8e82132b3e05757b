"""Frames through the OpenFX plug-in while servers are killed; ``tools.reliability.openfx`` makes a thousand."""

import sys

import pytest

from tests.openfx.conftest import compiler
from tools.reliability.openfx import render_many


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="finds the server as Linux shows it")
@pytest.mark.skipif(not compiler(), reason="there is no C compiler (CC, cc or gcc)")
def test_every_frame_is_made_or_said_to_have_failed_and_nothing_is_left() -> None:
    outcome = render_many(60, 6)
    assert outcome.faults == []
    assert outcome.frames == 60
    assert outcome.kills >= 6
