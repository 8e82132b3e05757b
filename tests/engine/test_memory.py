import sys

import numpy as np
import pytest

from flowabs_nodes.engine import memory


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("16GB", 16e9),
        ("16G", 16e9),
        ("16g", 16e9),
        ("1.5GiB", 1.5 * 2**30),
        ("900M", 9e8),
        ("900 MB", 9e8),
        ("2000000k", 2e9),
        ("1T", 1e12),
        ("5000000", 5e6),
        (5_000_000, 5e6),
        ("64MiB", 2**26),
    ],
)
def test_sizes(text, size):
    assert memory.parse_memory(text) == size


@pytest.mark.parametrize("text", ["", "GB", "-1G", "1e9", "16 XB", "1,5G", "half", "0", "10k", "nan", None])
def test_what_is_no_size(text):
    with pytest.raises(ValueError, match="found"):
        memory.parse_memory(text)


def test_a_share_of_what_there_is():
    assert memory.parse_memory("50%") == pytest.approx(memory.available_memory() / 2, rel=1e-6)


@pytest.mark.parametrize(
    ("own", "files", "expected"),
    [
        ("0::/\n", {"memory.max": "1000\n"}, 1000),
        ("0::/a/b\n", {"memory.max": "max", "a/memory.max": "3000", "a/b/memory.max": "max"}, 3000),
        ("0::/a/b\n", {"a/memory.max": "500", "a/b/memory.max": "900"}, 500),
        ("3:memory:/m\n", {"memory/m/memory.limit_in_bytes": "700"}, 700),
        ("3:cpu:/m\n", {"memory/m/memory.limit_in_bytes": "700"}, 10**6),
        ("0::/\n", {"memory.max": "9223372036854771712"}, 10**6),
        ("0::/\n", {}, 10**6),
        ("", {}, 10**6),
    ],
)
def test_what_a_container_gives(tmp_path, own, files, expected):
    (tmp_path / "own").write_text(own)
    for name, content in files.items():
        file = tmp_path / "groups" / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(content)
    assert memory.available_memory(tmp_path / "groups", tmp_path / "own", of_machine=10**6) == expected


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux counts from a moment on")
def test_the_peak_is_that_since_it_was_reset():
    large = np.ones(200 * 2**20, np.uint8)
    del large
    memory.reset_peak()
    before = memory.peak_since_reset()
    large = np.ones(100 * 2**20, np.uint8)
    del large
    assert 90 * 2**20 < memory.peak_since_reset() - before < 150 * 2**20
    assert memory.resident() <= memory.peak_since_reset()
