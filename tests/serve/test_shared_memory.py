"""Memory of clients: a plain file of this user alone, as long as it is said to be, now and later."""

import os
import sys

import pytest

from flowabs_nodes.errors import CommandError
from flowabs_nodes.serve.shared_memory import opened_file, opened_name

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="memory has names there")


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "memory"
    path.write_bytes(b"x" * 4096)
    path.chmod(0o600)
    return path


def test_what_one_writes_the_other_reads_when_the_name_is_gone_too(file):
    descriptor = os.open(file, os.O_RDWR)
    memory = opened_file(str(file), 4096)
    file.unlink()
    memory.view[10:13] = b"abc"
    assert os.pread(descriptor, 5, 9) == b"xabcx"
    os.close(descriptor)


def link(file):
    (file.parent / "link").symlink_to(file)
    return file.parent / "link"


def shared(file):
    file.chmod(0o640)
    return file


def pipe(file):
    os.mkfifo(file.parent / "pipe", 0o600)
    return file.parent / "pipe"


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (link, "symbolic link"),
        (shared, "expected a file of this user alone, 0600, found 0640"),
        (pipe, "expected a plain file"),
        (lambda file: file.parent, "directory"),
        (lambda file: file.parent / "none", "No such file"),
        (lambda file: f"{file}\0", "null byte"),
    ],
)
def test_other_things_are_refused(file, make, said):
    with pytest.raises(CommandError, match=said) as raised:
        opened_file(str(make(file)), 4096)
    assert raised.value.code == "bad-memory"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can make another's file")
def test_a_file_of_another_user_is_refused(file):
    os.chown(file, 12345, -1)
    with pytest.raises(CommandError, match="of this user alone"):
        opened_file(str(file), 4096)


def test_a_file_that_is_shorter_is_refused_at_once_and_later(file):
    with pytest.raises(CommandError, match="expected 4097 bytes, found 4096"):
        opened_file(str(file), 4097)
    memory = opened_file(str(file), 4096)
    memory.check()
    os.truncate(file, 100)
    with pytest.raises(CommandError, match="expected 4096 bytes, found 100"):
        memory.check()


def test_names_are_for_windows():
    with pytest.raises(CommandError, match="a path on this system"):
        opened_name("flowabs-1", 10)
