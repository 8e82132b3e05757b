"""A file is read once for each of its versions."""

import builtins
import os

import pytest

from flowabs_nodes.file_hash import file_hash


def test_each_version_is_read_once(tmp_path, monkeypatch):
    path = tmp_path / "a"
    path.write_bytes(b"one")
    before = file_hash(path)
    monkeypatch.setattr(builtins, "open", lambda *arguments: pytest.fail("read again"))
    assert file_hash(path) == before
    monkeypatch.undo()
    path.write_bytes(b"two")
    os.utime(path, ns=(1, 1))
    assert file_hash(path) != before
    with pytest.raises(FileNotFoundError):
        file_hash(tmp_path / "none")
