"""Runs of which something is killed, six of them; ``python -m tools.reliability.kills`` kills hundreds."""

import random
import sys

import pytest

from tools.reliability.kills import kill

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="finds the processes of a run as Linux shows them")


@pytest.mark.slow
def test_no_frame_is_lost_or_half_made_where_something_is_killed() -> None:
    chance = random.Random(20093)
    outcomes = [kill(victim, chance.uniform(0.3, 5.0), frames=8) for victim in ("run", "worker") * 3]
    assert not [f"{each.victim} at {each.moment:.2f} s: {each.faults}" for each in outcomes if each.faults]
