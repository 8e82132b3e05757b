"""What a lock says, and to whom."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flowabs_nodes.io import file_lock

pytest.importorskip("fcntl")


def test_a_lock_is_seen_through_another_open_file(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    assert file_lock.is_locked(path) is False
    with path.open() as file:
        assert file_lock.lock(file.fileno())
        assert file_lock.is_locked(path) is True
        file_lock.unlock(file.fileno())
        assert file_lock.is_locked(path) is False
    assert file_lock.is_locked(tmp_path / "none") is None


def test_only_regular_files_are_opened(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to("/dev/zero")
    for path in (tmp_path / "pipe", tmp_path / "link", tmp_path, Path("/dev/zero")):
        assert file_lock.open_regular(path) is None
        assert file_lock.is_locked(path) is None


def test_processes_of_one_kernel_have_one_reach_in_a_folder(tmp_path: Path) -> None:
    code = "import sys; from flowabs_nodes.io.file_lock import reach; print(reach(sys.argv[1]))"
    command = [sys.executable, "-c", code, str(tmp_path)]
    other = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    assert other == file_lock.reach(tmp_path) != file_lock.NOWHERE
    assert file_lock.reach("/proc") != file_lock.reach(tmp_path), "another file system"
    assert file_lock.reach(tmp_path / "none") == file_lock.NOWHERE


def test_a_kernel_without_a_name_reaches_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_lock, "_kernel", lambda: "")
    assert file_lock.reach(tmp_path) == file_lock.NOWHERE
