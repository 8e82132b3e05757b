"""Who may write a frame, and what becomes of its file."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.io import claim_files, file_lock
from flowabs_nodes.io.claim import ClaimedError, claim
from flowabs_nodes.io.claim_files import HOST, ClaimFile, claim_path, stem, temporary_path
from flowabs_nodes.io.claim_watch import SILENCE, ClaimWatch
from flowabs_nodes.io.heartbeat import HEARTBEAT
from flowabs_nodes.signals import before_the_end
from tests.io.claims import HOLD, Clock, holder, left, left_by

pytest.importorskip("fcntl")


def test_publish(tmp_path: Path) -> None:
    final = tmp_path / "new" / "folder" / "out.exr"
    with claim(final) as held:
        assert held.temporary == final.parent / f".out.exr.{HOST}.{held.writer.token}.tmp"
        assert left(final.parent) == sorted([held.temporary.name, ".out.exr.claim"])
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


def test_holds(tmp_path: Path) -> None:
    with claim(tmp_path / "out.exr") as held:
        held.write(b"frame")
        assert held.holds(b"frame")
        assert not any(held.holds(other) for other in (b"", b"fram", b"frame!", b"frane"))


def test_a_living_writer_is_respected(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    other = holder(final)
    try:
        with pytest.raises(ClaimedError, match=rf"on {HOST} \(process {other.pid}\)") as caught, claim(final):
            pass
        assert caught.value.code == "claimed"
        assert caught.value.file == str(final)
        with claim(tmp_path / "another.exr"):  # only that one frame
            pass
    finally:
        other.communicate("go\n", timeout=120)
    assert final.read_bytes() == b"half a fr"


def test_a_killed_writer_is_taken_over_at_once(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    other = holder(final)
    other.kill()
    other.wait()
    assert len(left(tmp_path)) == 2
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
    assert f"process {os.getpid()}" in errors[0]
    assert left(tmp_path) == []


@pytest.mark.parametrize("dead", [False, True], ids=["new", "taking over a dead one"])
def test_many_at_once_exactly_one_wins(tmp_path: Path, dead: bool) -> None:
    final = tmp_path / "out.exr"
    if dead:
        left_by(final, HOST, file_lock.reach(tmp_path) + "ab" * 5)
    code = HOLD.replace("with claim", "sys.stdin.readline()\nwith claim").replace('print("holding"', 'print("won"')
    others = [
        subprocess.Popen([sys.executable, "-c", code, str(final)], stdin=-1, stdout=-1, stderr=-1, text=True)
        for _ in range(3)
    ]
    for other in others:
        assert other.stdin is not None
        other.stdin.write("go\n")
        other.stdin.flush()
    deadline = time.monotonic() + 60
    while sum(other.poll() is not None for other in others) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    results = [other.communicate("done\n", timeout=120) for other in others]
    assert [out for out, _ in results].count("won\n") == 1
    assert sum("ClaimedError" in err for _, err in results) == 2
    assert left(tmp_path) == ["out.exr"]


def test_two_hosts_of_one_name_whose_locks_do_not_reach(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A container elsewhere may have our host's name: its free lock says nothing, and it lives while it is touched."""
    clock, final = Clock(), tmp_path / "out.exr"
    watch = ClaimWatch(clock)
    writer = left_by(final, HOST)
    for _ in range(3):
        with pytest.raises(ClaimedError), claim(final, watch):
            pass
        clock.now += SILENCE - 1
        os.utime(claim_path(final), ns=(int(clock.now), int(clock.now)))
    with pytest.raises(ClaimedError), claim(final, watch):
        pass
    clock.now += SILENCE
    with claim(final, watch) as held:
        assert held.writer != writer
        assert left(tmp_path) == sorted([held.temporary.name, ".out.exr.claim"])


def test_a_writer_that_was_taken_for_dead_publishes_nothing(tmp_path: Path) -> None:
    """It comes back, from a sleep of its machine, after another one has begun to write, and after that one is done."""
    final = tmp_path / "out.exr"
    with claim(final) as sleeper:
        sleeper.write(b"old")
        claim_path(final).unlink()  # as the other one does
        with claim(final) as other:
            with pytest.raises(ClaimedError, match="taken over"):
                sleeper.publish()
            other.write(b"new")
            other.publish()
            sleeper.release()
            assert claim_path(final).exists(), "the claim of the other one"
    assert final.read_bytes() == b"new"
    assert left(tmp_path) == ["out.exr"]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")
@pytest.mark.filterwarnings("ignore:This process:DeprecationWarning")
def test_a_forked_copy_of_the_process_holds_and_releases_nothing(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    with claim(final) as held:
        held.write(b"frame")
        child = os.fork()
        if child == 0:
            try:
                held.release()
                held.publish()
            except OSError:
                os._exit(0 if not HEARTBEAT.beats else 1)
            os._exit(2)
        assert os.waitpid(child, 0)[1] == 0
        assert file_lock.is_locked(held.temporary)
        assert file_lock.is_locked(claim_path(final))
        held.publish()
    assert final.read_bytes() == b"frame"


def test_a_copy_of_the_open_file_keeps_no_lock(tmp_path: Path) -> None:
    """A library may fork without telling Python, in the very moment in which the claim is closed."""
    file = ClaimFile(tmp_path / "file")
    copy = os.dup(file.fd)
    assert file_lock.is_locked(file.path)
    file.close()
    assert file_lock.is_locked(file.path) is False
    os.close(copy)


def test_files_are_not_handed_to_programs(tmp_path: Path) -> None:
    with claim(tmp_path / "out.exr") as held:
        assert not os.get_inheritable(held._guard.fd)
        assert not os.get_inheritable(held._temporary.fd)


@pytest.mark.parametrize("how", ["fails", "does nothing"])
def test_without_locks_time_tells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    def no_lock(fd: int, how_: int) -> None:
        if how == "fails":
            raise OSError("no locks here")

    monkeypatch.setattr(file_lock.fcntl, "flock", no_lock)
    clock, final = Clock(), tmp_path / "out.exr"
    watch = ClaimWatch(clock)
    with claim(final) as held:
        assert held.writer.reach == file_lock.NOWHERE
        with pytest.raises(ClaimedError), claim(final, watch):
            pass
        clock.now += SILENCE - 1
        with pytest.raises(ClaimedError), claim(final, watch):
            pass
        clock.now += 1
        with claim(final, watch) as other:
            other.write(b"frame")
            other.publish()
    assert left(tmp_path) == ["out.exr"]


def test_windows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No locks at all, and no file is renamed or removed while it is open."""
    monkeypatch.setattr(file_lock, "fcntl", None)
    opened: list[str] = []
    unlink, replace = os.unlink, os.replace

    def closed(path: str | os.PathLike[str]) -> None:
        opened.extend(each for each in os.listdir("/proc/self/fd") if _leads_to(each, path))

    def _leads_to(fd: str, path: str | os.PathLike[str]) -> bool:
        return os.path.exists(f"/proc/self/fd/{fd}") and os.path.samefile(f"/proc/self/fd/{fd}", path)

    if os.path.isdir("/proc/self/fd"):
        monkeypatch.setattr(os, "unlink", lambda path: (os.path.exists(path) and closed(path), unlink(path)))
        monkeypatch.setattr(os, "replace", lambda path, final: (closed(path), replace(path, final)))
    final = tmp_path / "out.exr"
    with claim(final) as held:
        held.write(b"frame")
        held.publish()
    with claim(tmp_path / "other.exr") as held:
        held.write(b"half")
    assert left(tmp_path) == ["out.exr"]
    assert opened == []
    clock = Clock()
    watch = ClaimWatch(clock)
    left_by(final)
    with pytest.raises(ClaimedError), claim(final, watch):
        pass
    clock.now += SILENCE
    with claim(final, watch):
        pass
    assert left(tmp_path) == ["out.exr"]


@pytest.mark.parametrize("name", ["cat@2x.#1.exr", "x" * 251 + ".exr", "é" * 125 + ".exr", "new\nline.exr"])
def test_names(tmp_path: Path, name: str) -> None:
    """Signs of sequences, names as long as names can be, in letters of two bytes too."""
    final = tmp_path / name
    writer = left_by(final, HOST, file_lock.reach(tmp_path) + "ab" * 5)
    assert max(len(os.fsencode(each)) for each in left(tmp_path)) <= 255
    with claim(final) as held:
        assert held.writer != writer
        held.write(b"frame")
        held.publish()
    assert left(tmp_path) == [name]


def test_two_long_names_are_two(tmp_path: Path) -> None:
    one, two = "x" * 247 + "0001.exr", "x" * 247 + "0002.exr"
    assert stem(one) != stem(two)
    assert stem("short.exr") == "short.exr"
    with claim(tmp_path / one), claim(tmp_path / two):
        assert len(left(tmp_path)) == 4


def test_what_cannot_be_replaced(tmp_path: Path) -> None:
    (tmp_path / "out.exr").mkdir()
    os.mkfifo(tmp_path / "pipe.exr")
    for name, what in (("out.exr", "a folder"), ("pipe.exr", "a pipe")):
        with pytest.raises(WriteError, match=what), claim(tmp_path / name):
            pass
    (tmp_path / "file").touch()
    with pytest.raises(WriteError), claim(tmp_path / "file" / "out.exr"):
        pass
    with pytest.raises(WriteError), claim(tmp_path / ("x" * 300 + ".exr")):
        pass


@pytest.mark.parametrize("kind", ["pipe", "folder", "link to /dev/zero"])
def test_what_is_no_claim_but_has_the_name_of_one_is_named(tmp_path: Path, kind: str) -> None:
    guard = claim_path(tmp_path / "out.exr")
    {"pipe": os.mkfifo, "folder": os.mkdir, "link to /dev/zero": lambda path: os.symlink("/dev/zero", path)}[kind](
        guard
    )
    with pytest.raises(WriteError, match=r"\.out\.exr\.claim") as caught, claim(tmp_path / "out.exr"):
        pass
    assert caught.value.code == "claim-blocked"
    assert "remove it" in caught.value.hint


@pytest.mark.parametrize("text", [b"", b"\0" * 10, b"x" * 100_000, b"../../etc passwd 1\n", "node é 1".encode()])
def test_a_claim_that_does_not_say_whose_it_is_waits_for_its_time(tmp_path: Path, text: bytes) -> None:
    clock, final = Clock(), tmp_path / "out.exr"
    watch = ClaimWatch(clock)
    claim_path(final).write_bytes(text)
    with pytest.raises(ClaimedError, match="by another run"), claim(final, watch):
        pass
    clock.now += SILENCE
    with claim(final, watch):
        pass
    assert left(tmp_path) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_unwritable_folders(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(WriteError) as caught, claim(tmp_path / "out.exr"):
            pass
        assert caught.value.code == "unwritable"
    finally:
        tmp_path.chmod(0o700)


def test_no_folder_is_listed_for_a_frame(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """40,000 other files in the folder must not slow each frame down."""

    def listed(*_: object) -> None:
        raise AssertionError("a folder was listed")

    monkeypatch.setattr(os, "listdir", listed)
    monkeypatch.setattr(os, "scandir", listed)
    left_by(tmp_path / "out.exr", HOST, file_lock.reach(tmp_path) + "ab" * 5)
    with claim(tmp_path / "out.exr") as held:
        held.write(b"frame")
        held.publish()
    assert temporary_path(tmp_path / "a", claim_files.new_writer("2" * 8)).name.startswith(f".a.{HOST}.22222222")


def test_before_a_process_ends_without_notice_the_files_of_its_claims_are_removed(tmp_path: Path) -> None:
    with claim(tmp_path / "a.exr") as first, claim(tmp_path / "b.exr"):
        first.write(b"half a frame")
        for act in before_the_end:
            act()
        assert os.listdir(tmp_path) == []
