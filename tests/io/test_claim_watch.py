"""Which claims live, and what is swept away."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from flowabs_nodes.io import claim_watch, file_lock
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.claim_files import HOST, burial_path, claim_path, look, temporary_path
from flowabs_nodes.io.claim_watch import SILENCE, ClaimWatch
from tests.io.claims import Clock, holder, left, left_by, touched

pytest.importorskip("fcntl")


def of_020(path: Path, host: str, pid: int) -> Path:
    """Write a temporary as version 0.2.0 named them."""
    made = path.parent / f".{path.name}.{host}.{pid}.tmp"
    made.write_bytes(b"half")
    return made


def test_a_claim_lives_while_its_time_changes_by_whatever_clock(tmp_path: Path) -> None:
    clock, final = Clock(), tmp_path / "out.exr"
    watch = ClaimWatch(clock)
    writer = left_by(final)
    for _ in range(5):
        assert watch.writer_of(final) == writer
        clock.now += SILENCE - 1
        touched(claim_path(final))  # backwards: clocks are never compared
    assert watch.writer_of(final) == writer
    clock.now += SILENCE - 1
    assert watch.writer_of(final) == writer
    clock.now += 1
    assert watch.writer_of(final) is None
    assert left(tmp_path) == []


def test_each_watcher_has_to_see_the_silence_itself(tmp_path: Path) -> None:
    final = tmp_path / "out.exr"
    left_by(final)
    os.utime(claim_path(final), (0, 0))
    assert ClaimWatch().writer_of(final) is not None, "its time is of 1970, but it may just have been touched"


def test_sweep(tmp_path: Path) -> None:
    clock, folder = Clock(), tmp_path / "out"
    folder.mkdir()
    near = file_lock.reach(folder)
    watch = ClaimWatch(clock)
    dead, far, other = folder / "shot.1001.exr", folder / "shot.1002.exr", folder / "other.exr"
    living = holder(folder / "shot.1004.exr")
    try:
        gone = left_by(dead, HOST, near + "ab" * 5)
        orphan = folder / f".shot.1003.exr.{HOST}.{near}{'cd' * 5}.tmp"
        orphan.touch()
        far_writer = left_by(far)
        left_by(other, HOST, near + "ef" * 5)
        strangers = [folder / ".shot.1001.exr.tmp", folder / ".shot.1001.exr.mine.old.tmp", folder / ".shot.claim"]
        for each in strangers:
            each.touch()
        there = set(left(folder))
        removed = watch.sweep(folder, "shot.####.exr")
        assert set(removed) == {claim_path(dead), temporary_path(dead, gone), orphan}
        assert set(left(folder)) == there - {path.name for path in removed}
        clock.now += SILENCE
        assert set(watch.sweep(folder, "shot.####.exr")) == {claim_path(far), temporary_path(far, far_writer)}
        assert all(each.exists() for each in (claim_path(other), *strangers))
        assert watch.sweep(tmp_path / "none", "a.exr") == []
    finally:
        living.communicate("go\n", timeout=120)
    assert (folder / "shot.1004.exr").exists()


def test_temporaries_of_0_2_0(tmp_path: Path) -> None:
    """They have no claim beside them and are never touched: a locked one lives, others are dead after a minute."""
    clock = Clock()
    watch = ClaimWatch(clock)
    dead, far = tmp_path / "shot.0001.exr", tmp_path / "shot.0002.exr"
    old, distant = of_020(dead, HOST, 999_999), of_020(far, "elsewhere", 7)
    held = of_020(tmp_path / "shot.0003.exr", HOST, os.getppid())
    with open(held, "rb") as file:
        file_lock.lock(file.fileno())
        assert watch.sweep(tmp_path, "shot.####.exr") == []
        assert str(watch.writer_of(far)) == "elsewhere (process 7)"
        clock.now += SILENCE
        assert watch.writer_of(far) is None
        assert not distant.exists()
        assert watch.sweep(tmp_path, "shot.####.exr") == [old]
        assert watch.writer_of(tmp_path / "shot.0003.exr") is not None
    assert watch.writer_of(tmp_path / "shot.0003.exr") is not None, "the minute begins when its lock is free"
    clock.now += SILENCE
    assert watch.writer_of(tmp_path / "shot.0003.exr") is None
    assert left(tmp_path) == []


def test_long_names_are_swept_too(tmp_path: Path) -> None:
    pattern = "x" * 240 + ".####.exr"
    final = tmp_path / pattern.replace("####", "0007")
    left_by(final, HOST, file_lock.reach(tmp_path) + "ab" * 5)
    assert ClaimWatch().sweep(tmp_path, pattern, frames=(1, 2)) == []
    assert len(ClaimWatch().sweep(tmp_path, pattern, frames=range(10))) == 2
    assert left(tmp_path) == []


def test_pipes_and_devices_are_not_opened(tmp_path: Path) -> None:
    near = file_lock.reach(tmp_path)
    os.mkfifo(tmp_path / f".a.exr.{HOST}.{near}{'ab' * 5}.tmp")
    os.symlink("/dev/zero", tmp_path / f".a.exr.{HOST}.{near}{'cd' * 5}.tmp")
    os.mkfifo(tmp_path / ".b.exr.claim")
    assert ClaimWatch().sweep(tmp_path, "a.exr", "b.exr") == []


def test_a_burial_that_comes_late_spares_the_new_claim(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between another's look and its burial the dead claim is buried, and a new one made: that one stays."""
    final = tmp_path / "out.exr"
    left_by(final, HOST, file_lock.reach(tmp_path) + "ab" * 5)
    late = ClaimWatch()
    found = look(claim_path(final))
    assert found is not None
    with claim(final) as held:
        assert not late._bury(final, found)
        assert late.writer_of(final) == held.writer
        assert claim_path(final).exists()
    assert left(tmp_path) == []


def test_a_burial_whose_maker_died_ends_after_a_minute(tmp_path: Path) -> None:
    clock, final = Clock(), tmp_path / "out.exr"
    watch = ClaimWatch(clock)
    writer = left_by(final, HOST, file_lock.reach(tmp_path) + "ab" * 5)
    found = look(claim_path(final))
    assert found is not None
    burial_path(final, found).touch()
    assert watch.writer_of(final) == writer
    clock.now += claim_watch.SILENCE
    watch.writer_of(final)
    assert watch.writer_of(final) is None
    assert left(tmp_path) == []
