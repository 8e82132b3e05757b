"""What all tests share: the same examples each time, nobody's ``$OCIO``, and a run that wastes no processor time.

Hypothesis looks at the same examples each time, so that a green suite stays green. Others are tried with ``pytest
--hypothesis-profile=default``.
"""

import gc
import os
import sys

import pytest
from hypothesis import settings

os.environ.pop("OCIO", None)  # a test that wants one sets it
settings.register_profile("steady", derandomize=True, deadline=None)
settings.load_profile("steady")

# Hundreds of processes are started, and each would compile the package's sources again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


def pytest_configure(config: pytest.Config) -> None:
    """Have pytest-xdist hand out files in the order of :func:`pytest_collection_modifyitems`, not by their length."""
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the files that take longest, so that no process is left alone with one at the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    counts: dict[object, int] = {}
    for item in items:
        counts[item.path] = counts.get(item.path, 0) + 1
    items.sort(key=lambda item: (item.path not in slow, -counts[item.path], str(item.path)))


def pytest_collection_finish() -> None:
    """Leave out of garbage collection what is there by now, which is a lot: some tests collect often."""
    gc.freeze()


@pytest.fixture
def quick_collection() -> None:
    """Leave out of garbage collection what earlier tests have loaded, for a test that collects again and again."""
    gc.collect()
    gc.freeze()


def pytest_unconfigure() -> None:
    """Let everything be collected again, and so be destroyed in good order when Python ends."""
    gc.unfreeze()
