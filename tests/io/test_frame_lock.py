"""Who may write a frame, and what is left when a writer dies."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io import frame_lock
from flowabs_nodes.io.frame_lock import HOST, ClaimedError, check_writable, claim, sweep

pytest.importorskip("fcntl")

HOLD = """
import sys, time
from flowabs_nodes.io.frame_lock import claim
with claim(sys.argv[1]) as held:
    held.write(b"half a fr")
    print("holding", flush=True)
    sys.stdin.readline()
    held.publish()
"""


def holder(path: Path) -> subprocess.Popen[str]:
    """Start another process, which holds a claim until it reads a line."""
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdin=-1, stdout=-1, text=True)
    assert process.stdout is not None
    assert process.stdout.readline() == "holding\n"
    return process


def temporary(path: Path, host: str, pid: int, age: float = 0.0) -> Path:
    made = path.parent / f".{path.name}.{host}.{pid}.tmp"
    made.write_bytes(b"half")
    os.utime(made, (time.time() - age,) * 2)
    return made


def left(folder: Path) -> list[str]:
    """Return the names of the files that are left in a folder."""
    return sorted(os.listdir(folder))


def test_publish(tmp_path: Path) -> None:
    final = tmp_path / "new" / "folder" / "out.exr"
    with claim(final) as held:
        assert held.temporary == final.parent / f".out.exr.{HOST}.{os.getpid()}.tmp"
        held.write(b"frame")
        assert not final.exists()
        held.publish()
    assert final.read_bytes() == b"frame"
    assert left(final.parent) == ["out.exr"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_nothing_is_left_after_an_error(tmp_path: Path, error: type[BaseException]) -> None:
    def fail() -> None:
        with claim(tmp_path / "out.exr") as held:
            held.write(b"half")
            raise error

    with pytest.raises(error):
        fail()
    assert left(tmp_path) == []


def test_a_link_is_replaced_and_its_target_untouched(tmp_path: Path) -> None:
    (tmp_path / "secret.txt").write_text("precious")
    (tmp_path / "out.exr").symlink_to("secret.txt")
    with claim(tmp_path / "out.exr") as held:
        held.write(b"frame")
        held.publish()
    assert (tmp_path / "secret.txt").read_text() == "precious"
    assert not (tmp_path / "out.exr").is_symlink()


def test_short_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: write(fd, bytes(data)[:3]))
    with claim(tmp_path / "out.exr") as held:
        held.write(b"0123456789")
        held.publish()
    assert (tmp_path / "out.exr").read_bytes() == b"0123456789"


def test_a_living_writer_is_respected(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    other = holder(final)
    try:
        with pytest.raises(ClaimedError, match=f"being written by {HOST}:{other.pid}") as caught, claim(final):
            pass
        assert caught.value.code == "claimed"
        assert caught.value.file == str(final)
        assert sweep(tmp_path, "out.exr") == []
        with claim(tmp_path / "another.exr"):  # only that one frame
            pass
    finally:
        other.communicate("go\n", timeout=120)
    assert final.read_bytes() == b"half a fr"


def test_a_killed_writer_is_swept_away(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    other = holder(final)
    other.kill()
    other.wait()
    assert len(left(tmp_path)) == 1
    with claim(final) as held:
        held.write(b"whole")
        held.publish()
    assert left(tmp_path) == ["out.exr"]


def test_another_thread_is_somebody_else(tmp_path: Path) -> None:
    errors: list[str] = []

    def try_it() -> None:
        try:
            with claim(tmp_path / "out.exr"):
                pass
        except ClaimedError as error:
            errors.append(str(error))

    with claim(tmp_path / "out.exr"):
        thread = threading.Thread(target=try_it)
        thread.start()
        thread.join()
    assert f"{HOST}:{os.getpid()}" in errors[0]
    assert left(tmp_path) == []


def test_many_at_once_exactly_one_wins(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    code = HOLD.replace("with claim", "sys.stdin.readline()\nwith claim").replace('print("holding"', 'print("won"')
    others = [
        subprocess.Popen([sys.executable, "-c", code, str(final)], stdin=-1, stdout=-1, stderr=-1, text=True)
        for _ in range(3)
    ]
    for other in others:
        assert other.stdin is not None
        other.stdin.write("go\n")
        other.stdin.flush()
    time.sleep(0.2)
    deadline = time.monotonic() + 20
    while sum(other.poll() is not None for other in others) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    results = [other.communicate("done\n", timeout=120) for other in others]
    assert [out for out, _ in results].count("won\n") == 1
    assert sum("ClaimedError" in err for _, err in results) == 2
    assert left(tmp_path) == ["out.exr"]


def test_sweep(tmp_path: Path) -> None:
    final = tmp_path / "shot.1001.exr"
    dead = temporary(final, HOST, 999_999)
    own = temporary(final, HOST, os.getpid())  # of an earlier process of this number: nobody holds its lock
    young = temporary(final, "elsewhere", 7)
    old = temporary(final, "elsewhere", 8, age=25 * 3600)
    foreign = temporary(tmp_path / "other.exr", HOST, 999_999)
    stranger = tmp_path / ".shot.1001.exr.tmp"
    stranger.touch()
    assert set(sweep(tmp_path, "shot.####.exr")) == {dead, own, old}
    assert set(tmp_path.iterdir()) == {young, foreign, stranger}
    assert sweep(tmp_path / "none", "a.exr") == []


def test_other_hosts_are_believed_for_a_day(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    temporary(final, "elsewhere", 7, age=23 * 3600)
    with pytest.raises(ClaimedError, match="elsewhere:7"), claim(final):
        pass
    temporary(final, "elsewhere", 7, age=25 * 3600)
    with claim(final) as held:
        held.write(b"frame")
        held.publish()
    assert left(tmp_path) == ["out.exr"]


def test_without_locks_the_process_tells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_lock(fd: int, how: int) -> None:
        raise OSError("no locks here")

    final = tmp_path / "out.exr"
    monkeypatch.setattr(frame_lock.fcntl, "flock", no_lock)
    temporary(final, HOST, os.getppid())
    with pytest.raises(ClaimedError, match=f":{os.getppid()}"), claim(final):
        pass
    os.unlink(next(tmp_path.iterdir()))
    temporary(final, HOST, 999_999)
    with claim(final) as held:
        held.write(b"frame")
        held.publish()
    assert left(tmp_path) == ["out.exr"]


def test_without_locks_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows: a claim lives as long as it is young, and no file is renamed or removed while it is open."""
    monkeypatch.setattr(frame_lock, "fcntl", None)
    final = tmp_path / "out.exr"
    with claim(final) as held:
        held.write(b"frame")
        held.publish()
    with claim(tmp_path / "other.exr") as held:
        held.write(b"half")
    assert left(tmp_path) == ["out.exr"]
    temporary(final, HOST, 999_999)
    with pytest.raises(ClaimedError), claim(final):
        pass
    temporary(final, HOST, 999_999, age=25 * 3600)
    with claim(final):
        pass
    assert left(tmp_path) == ["out.exr"]


def test_holds(tmp_path: Path) -> None:
    with claim(tmp_path / "out.exr") as held:
        held.write(b"frame")
        assert held.holds(b"frame")
        assert not any(held.holds(other) for other in (b"", b"fram", b"frame!", b"frane"))


def test_names_with_signs_of_sequences(tmp_path: Path) -> None:
    final = tmp_path / "cat@2x.#1.exr"
    temporary(final, HOST, 999_999)
    with claim(final) as held:
        held.write(b"frame")
        held.publish()
    assert left(tmp_path) == [final.name]


def test_a_folder_of_that_name(tmp_path: Path) -> None:
    (tmp_path / "out.exr").mkdir()
    with pytest.raises(WriteError, match="folder"), claim(tmp_path / "out.exr"):
        pass
    (tmp_path / "file").touch()
    with pytest.raises(WriteError), claim(tmp_path / "file" / "out.exr"):
        pass
    with pytest.raises(WriteError), claim(tmp_path / ("x" * 300 + ".exr")):
        pass


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_folders(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(WriteError) as caught, claim(tmp_path / "out.exr"):
            pass
        assert caught.value.code == "unwritable"
        with pytest.raises(WriteError):
            check_writable(tmp_path / "new" / "folder")
    finally:
        tmp_path.chmod(0o700)


def test_check_writable_leaves_nothing(tmp_path: Path) -> None:
    check_writable(tmp_path / "new" / "folder")
    assert left(tmp_path) == []
    with pytest.raises(WriteError):
        check_writable("/proc/none")
