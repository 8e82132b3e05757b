"""Folders and names that cannot be written to are told before it is tried."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io.write_failure import check_replaceable, check_writable, failure


def test_check_writable_leaves_nothing(tmp_path: Path) -> None:
    check_writable(tmp_path / "new" / "folder")
    assert os.listdir(tmp_path) == []
    with pytest.raises(WriteError):
        check_writable("/proc/none")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_check_writable_of_a_folder_without_the_right(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(WriteError) as caught:
            check_writable(tmp_path / "new" / "folder")
        assert caught.value.code == "unwritable"
    finally:
        tmp_path.chmod(0o700)


def test_what_a_frame_may_replace(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to(tmp_path)
    for name in ("none", "file", "link", "file/below"):
        check_replaceable(tmp_path / name)
    os.mkfifo(tmp_path / "pipe")
    for path, what in ((tmp_path, "a folder"), (tmp_path / "pipe", "a pipe"), (Path("/dev/zero"), "a device")):
        with pytest.raises(WriteError, match=what) as caught:
            check_replaceable(path)
        assert caught.value.code == "not-a-file"


@pytest.mark.parametrize(
    ("number", "code"), [(errno.ENOSPC, "disk-full"), (errno.EROFS, "unwritable"), (errno.EIO, "write-failed")]
)
def test_what_an_error_of_the_system_means(number: int, code: str) -> None:
    error = failure(OSError(number, os.strerror(number)), "out.exr")
    assert (error.code, error.file) == (code, "out.exr")
