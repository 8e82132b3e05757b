"""Frame ranges, frame tokens, and what to read for a frame that is missing."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flowabs_nodes.errors import CommandError, ReadError
from flowabs_nodes.io.sequences import Sequence, Source, parse_frames


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", (7,)),
        ("1-5", (1, 2, 3, 4, 5)),
        ("1-10x4,200", (1, 5, 9, 200)),
        ("-2-1", (-2, -1, 0, 1)),
        ("-5--3", (-5, -4, -3)),
        ("5-1x2", (5, 3, 1)),
        (" 1-3 , 2 ", (1, 2, 3)),
    ],
)
def test_ranges(text: str, frames: tuple[int, ...]) -> None:
    assert parse_frames(text) == frames


@pytest.mark.parametrize(
    "text", ["", "a", "1-", "-", "1-3x0", "1..3", "1-10:4", "1-10y3", "1-3x-1", "1,,2", "1.5", "1-2-3"]
)
def test_not_a_range(text: str) -> None:
    with pytest.raises(CommandError, match="not a frame range") as caught:
        parse_frames(text)
    assert caught.value.code == "bad-frames"


def test_fileseqs_stagger_is_refused_with_a_hint() -> None:
    with pytest.raises(CommandError, match="1-10x4"):
        parse_frames("1-10:4")


def test_a_huge_range_is_refused_at_once() -> None:
    start = time.process_time()
    for text in ("1-1000000000", "1-999999999999999999", "1-900000,1000001-1900000"):
        with pytest.raises(CommandError, match="more than"):
            parse_frames(text)
    assert time.process_time() - start < 5  # a tenth of that when alone; a list of all would take minutes


@pytest.mark.parametrize("name", ["shot.####.exr", "shot.%04d.exr", "shot.$F4.exr", "shot.@@@@.exr"])
def test_tokens(name: str) -> None:
    sequence = Sequence(f"/folder##/{name}")
    assert sequence.has_token
    assert sequence.path(1001) == "/folder##/shot.1001.exr"
    assert sequence.path(7) == "/folder##/shot.0007.exr"
    assert sequence.path(-7) == "/folder##/shot.-007.exr"
    assert sequence.path(12345) == "/folder##/shot.12345.exr"


def test_one_hash_is_no_padding() -> None:
    assert Sequence("a.#.exr").path(7) == "a.7.exr"


def test_a_name_without_a_token_is_every_frame() -> None:
    for name in ("plate.exr", "plate.0001.exr", "100%done.exr", "cash$.exr"):
        sequence = Sequence(name)
        assert not sequence.has_token
        assert sequence.path(5) == name


@pytest.mark.parametrize("name", ["a.####.v##.exr", "a.1-10####.exr"])
def test_refused_names(name: str) -> None:
    with pytest.raises(CommandError) as caught:
        Sequence(name)
    assert caught.value.file == name


@given(st.integers(-(10**6), 10**6))
def test_a_frame_and_its_name(frame: int) -> None:
    sequence = Sequence("shot.####.exr")
    assert sequence.frame_of(sequence.path(frame)) == frame


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text("x")


def test_widths_are_strict(tmp_path: Path) -> None:
    touch(
        tmp_path,
        "s.0001.exr",
        "s.2.exr",
        "s.003.exr",
        "s.12345.exr",
        "s.-001.exr",
        "s.00007.exr",
        "s.0004.png",
        "ss.0005.exr",
    )
    assert Sequence(str(tmp_path / "s.####.exr")).frames_on_disk() == (-1, 1, 12345)
    assert Sequence(str(tmp_path / "s.#.exr")).frames_on_disk() == (2, 12345)


def test_frames_on_disk_of_nothing(tmp_path: Path) -> None:
    assert Sequence(str(tmp_path / "no" / "s.####.exr")).frames_on_disk() == ()
    assert Sequence(str(tmp_path / "s.exr")).frames_on_disk() == ()
    touch(tmp_path, "s.exr")
    assert Sequence(str(tmp_path / "s.exr")).frames_on_disk() == (1,)


def test_missing_policies(tmp_path: Path) -> None:
    touch(tmp_path, "s.0010.exr", "s.0014.exr")
    sequence = Sequence(str(tmp_path / "s.####.exr"))
    path = sequence.path
    assert sequence.resolve(10) == Source(path(10), 10)
    assert sequence.resolve(12, "hold") == Source(path(10), 12)
    assert sequence.resolve(13, "nearest") == Source(path(14), 13)
    assert sequence.resolve(12, "nearest") == Source(path(10), 12)  # a tie goes to the earlier
    assert sequence.resolve(13, "black") == Source(path(14), 13, black=True)
    assert sequence.resolve(13, "skip") == Source(None, 13, skip=True)
    with pytest.raises(ReadError, match="no such file") as caught:
        sequence.resolve(12)
    assert (caught.value.code, caught.value.file, caught.value.frame) == ("missing-file", path(12), 12)
    with pytest.raises(ReadError, match="no earlier frame"):
        sequence.resolve(9, "hold")
    assert sequence.resolve(10, "black") == Source(path(10), 10)


def test_missing_with_nothing_there(tmp_path: Path) -> None:
    for missing in ("hold", "nearest", "black", "error"):
        with pytest.raises(ReadError, match="no such file"):
            Sequence(str(tmp_path / "s.####.exr")).resolve(1, missing)
        with pytest.raises(ReadError, match="no such file"):
            Sequence(str(tmp_path / "none" / "s.exr")).resolve(1, missing)


def test_a_folder_that_may_not_be_entered_is_no_missing_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str, **options: object) -> None:
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr(os, "stat", refuse)
    with pytest.raises(ReadError, match="cannot be read: Permission denied") as caught:
        Sequence("closed/plate.####.exr").resolve(3)
    assert (caught.value.code, caught.value.file) == ("read-failed", "closed/plate.0003.exr")


@pytest.mark.parametrize(
    "name", ["icon@2x.png", "take#2.exr", "o@2x.exr", "a@3x.tif", "#1.exr", "v@10.jpg", "$Final.exr"]
)
def test_names_that_only_look_like_sequences(tmp_path: Path, name: str) -> None:
    touch(tmp_path, name)
    assert not Sequence.to_read(str(tmp_path / name)).has_token
    assert Sequence.to_read(str(tmp_path / name)).frames_on_disk() == (1,)
    if "$" not in name:
        assert Sequence(name).path(1) == name  # nothing has to be there for it to be written


@pytest.mark.parametrize("name", ["a.####.exr", "a.%04d.exr", "a.$F4.exr", "a@@@.exr", "a.#.exr"])
def test_a_file_of_the_very_name_is_that_file(tmp_path: Path, name: str) -> None:
    assert Sequence.to_read(str(tmp_path / name)).has_token
    touch(tmp_path, name)
    assert Sequence.to_read(str(tmp_path / name)).resolve(7).path == str(tmp_path / name)


def test_a_token_beside_what_is_none() -> None:
    assert Sequence("icon@2x.####.png").path(7) == "icon@2x.0007.png"
    assert Sequence("take#2_%03d.exr").path(7) == "take#2_007.exr"


def test_blenders_negative_frames(tmp_path: Path) -> None:
    touch(tmp_path, "b-0002.exr", "b-0001.exr", "b0000.exr", "b0001.exr")
    sequence = Sequence(str(tmp_path / "b####.exr"))
    assert sequence.frames_on_disk() == (-2, -1, 0, 1)
    assert sequence.resolve(-1).path == str(tmp_path / "b-0001.exr")
    assert sequence.resolve(-5, "nearest").path == str(tmp_path / "b-0002.exr")
    assert sequence.passed_over() == ()
    touch(tmp_path, "b-001.exr")  # as printf writes it: then Blender's is one too many
    assert sequence.resolve(-1).path == str(tmp_path / "b-001.exr")
    assert sequence.passed_over() == ("b-0001.exr",)


def test_frames_of_another_width_are_named(tmp_path: Path) -> None:
    touch(
        tmp_path, "s.0001.exr", "s.2.exr", "s.003.exr", "s.00007.exr", "s.12345.exr", "s.-1.exr", "s.x.exr", "t.1.exr"
    )
    assert Sequence(str(tmp_path / "s.####.exr")).passed_over() == ("s.-1.exr", "s.00007.exr", "s.003.exr", "s.2.exr")
    assert Sequence(str(tmp_path / "s.exr")).passed_over() == ()
    assert Sequence(str(tmp_path / "no" / "s.#.exr")).passed_over() == ()


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("move.0004.exr", 4),
        ("shot/move.1001.png", 1001),
        ("move.-12.exr", -12),
        ("move.0004", None),
        ("move_0004.exr", None),
        ("move.v2.exr", None),
        ("2024.exr", None),
        ("a.7.b.exr", None),
        ("move.####.exr", None),
        ("move.12345678901.exr", None),
    ],
)
def test_the_number_of_a_single_picture(name, number):
    assert Sequence(name).number_in_name == number


@pytest.mark.parametrize(
    ("text", "example"),
    [("1001-1100:2", "1001-1100x2"), ("5,-5--1:2", "-5--1x2"), (":", "1-10x4"), ("1-9:0", "1-10x4")],
)
def test_a_step_with_a_colon_is_refused_and_written_with_x(text: str, example: str) -> None:
    with pytest.raises(CommandError) as caught:
        parse_frames(text)
    assert f"with x: {example};" in caught.value.hint


@pytest.mark.parametrize("token", ["%0999d", "$F99999999", "#" * 300, "%021d"])
def test_a_number_of_too_many_digits_is_refused_at_once(token):
    with pytest.raises(CommandError, match="at most 20 digits"):
        Sequence(f"out/a.{token}.exr").path(1)
