"""What tests of whole runs begin with: plates to read, and a place to write to."""

import pytest

from tests.engine.sequences import plates


@pytest.fixture
def shot(tmp_path):
    """Write three plates and return their pattern."""
    return plates(tmp_path / "in", 1, 2, 3)


@pytest.fixture
def out(tmp_path):
    """Return the pattern of files in a folder that is not there yet."""
    return str(tmp_path / "out" / "toon.####.exr")
