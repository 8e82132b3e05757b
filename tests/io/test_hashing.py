"""A content's hash changes with the content, and with nothing else."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.hashing import content_hash


def test_only_the_bytes_count(tmp_path: Path) -> None:
    a, b, c = tmp_path / "a", tmp_path / "b", tmp_path / "c"
    a.write_bytes(b"plate")
    b.write_bytes(b"plate")
    c.write_bytes(b"Plate")
    os.utime(b, (0, 0))
    assert content_hash(a) == content_hash(b) != content_hash(c)


def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"one")
    before = content_hash(path)
    path.write_bytes(b"two")
    os.utime(path, ns=(1, 1))
    assert content_hash(path) != before


def test_missing(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="no such file") as caught:
        content_hash(tmp_path / "none")
    assert caught.value.code == "missing-file"
    with pytest.raises(ReadError, match="cannot be read"):
        content_hash(tmp_path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_what_never_ends_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.exr")
    (tmp_path / "zero.exr").symlink_to("/dev/zero")
    for name, what in (("pipe.exr", "a pipe"), ("zero.exr", "a device"), (".", "a folder")):
        with pytest.raises(ReadError, match=what) as caught:
            content_hash(tmp_path / name)
        assert caught.value.code == "not-a-file"
