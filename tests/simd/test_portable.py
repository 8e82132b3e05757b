"""Where the processor has AVX-512, the other path passes the same tests."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flowabs_nodes.simd.target import PATH

TESTS = Path(__file__).parent.parent


@pytest.mark.slow
@pytest.mark.skipif(PATH == "portable", reason="this is the portable path")
def test_the_portable_path_passes_the_tests_of_all_kernels() -> None:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "simd", "sampling", "filters", "color"]
    found = subprocess.run(
        [*command, f"--deselect=simd/{Path(__file__).name}"],
        cwd=TESTS,
        env={**os.environ, "FLOWABS_SIMD": "portable", "PYTHONPATH": str(TESTS.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stdout[-4000:] + found.stderr[-1000:]
