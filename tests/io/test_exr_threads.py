"""OpenEXR's threads: the same file with any number of them, none left behind, and forks that encode."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from flowabs_nodes.image import Image
from flowabs_nodes.io.exr_threads import encoding_threads
from flowabs_nodes.io.write import build_picture, save
from flowabs_nodes.simd.bands import limited

PIXELS = np.random.default_rng(4).normal(0.4, 0.3, (150, 90, 3)).astype(np.float32)
PICTURE = build_picture(Image.from_array(PIXELS), compression="zip")


@pytest.fixture(autouse=True)
def _an_empty_pool() -> Iterator[None]:
    assert OpenEXR.global_thread_count() == 0
    yield
    assert OpenEXR.global_thread_count() == 0


def encoded(path: Path, threads: int) -> bytes:
    """Return the bytes of the file that so many threads make of the picture."""
    with limited(threads):
        save(PICTURE, path, key="k")
    return path.read_bytes()


def test_any_number_of_threads_makes_the_same_file(tmp_path: Path) -> None:
    one = encoded(tmp_path / "1.exr", 1)
    assert encoded(tmp_path / "2.exr", 2) == one
    assert encoded(tmp_path / "5.exr", 5) == one


def test_inside_the_pool_has_the_threads_of_the_kernels() -> None:
    with limited(3), encoding_threads():
        assert OpenEXR.global_thread_count() == 3
    with limited(1), encoding_threads():
        assert OpenEXR.global_thread_count() == 0


def test_the_pool_is_empty_after_an_error() -> None:
    with pytest.raises(RuntimeError, match="disk"), limited(2), encoding_threads():
        raise RuntimeError("disk")


def test_a_pool_that_somebody_else_filled_is_left_alone() -> None:
    OpenEXR.set_global_thread_count(2)
    try:
        with limited(4), encoding_threads():
            assert OpenEXR.global_thread_count() == 2
        assert OpenEXR.global_thread_count() == 2
    finally:
        OpenEXR.set_global_thread_count(0)


def test_several_at_once(tmp_path: Path) -> None:
    one = encoded(tmp_path / "1.exr", 1)
    made: dict[int, bytes] = {}

    def work(index: int) -> None:
        made[index] = encoded(tmp_path / f"at_once_{index}.exr", 2)

    threads = [threading.Thread(target=work, args=(index,)) for index in range(4)]
    for each in threads:
        each.start()
    for each in threads:
        each.join(60)
    assert made == dict.fromkeys(range(4), one)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_child_of_a_fork_encodes_with_threads_too(tmp_path: Path) -> None:
    """Also where the fork comes while another thread is at it: it waits for the end."""
    one = encoded(tmp_path / "1.exr", 2)
    begun, over = threading.Event(), threading.Event()

    def work() -> None:
        with limited(2), encoding_threads():
            begun.set()
            over.wait(0.3)

    other = threading.Thread(target=work)
    other.start()
    assert begun.wait(30)
    child = os.fork()
    if child == 0:
        signal.alarm(30)
        os._exit(0 if encoded(tmp_path / "2.exr", 2) == one else 1)
    over.set()
    other.join(30)
    assert os.waitpid(child, 0)[1] == 0
