"""A run touches no file outside its root, and takes no name that a file cannot have."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.sequences import Sequence
from flowabs_nodes.io.settings import Settings, checked, refuse_shell_words, within


def test_within_a_root(tmp_path: Path) -> None:
    root = tmp_path / "root"
    (root / "sub").mkdir(parents=True)
    assert within(root / "sub" / "new.exr", root)
    assert within(root / "sub" / ".." / "a.exr", root)
    assert not within(root / "sub" / ".." / ".." / "a.exr", root)
    assert not within("/etc/passwd", root)
    assert not within(tmp_path / "root2" / "a.exr", root)


def test_symbolic_links_are_followed(tmp_path: Path) -> None:
    root, outside = tmp_path / "root", tmp_path / "outside"
    root.mkdir()
    outside.mkdir()
    (root / "folder").symlink_to(outside)
    (root / "file.exr").symlink_to(outside / "secret.exr")
    (root / "loop").symlink_to(root / "loop")
    assert not within(root / "folder" / "a.exr", root)
    assert not within(root / "file.exr", root)
    with pytest.raises(CommandError, match="outside") as caught:
        checked(root / "folder" / "a.exr", Settings(root=root))
    assert caught.value.code == "outside-root"
    assert checked(root / "a.exr", Settings(root=root)) == root / "a.exr"


@pytest.mark.parametrize(
    "name", ["", "a\0b.exr", "file:///etc/x.exr", "file:/etc/x.exr", "http://x/y.exr", "s3://shots/x.exr"]
)
def test_names_no_file_has(name: str) -> None:
    with pytest.raises(CommandError) as caught:
        checked(name, Settings())
    assert caught.value.code == "bad-path"


@pytest.mark.parametrize(
    "name",
    [
        *("~/x.exr", "~me/x.exr", "~", "$SHOT/x.exr", "${SHOT}/x.exr", "a/$SHOT.####.exr", "$F_SHOT/a.exr"),
        *("%USERPROFILE%/x.exr", "a/%SHOT%.exr", r"C:\shots\x.exr", "C:/x.exr", r"\\server\x.exr", r"shots\x.exr"),
        *("C:x.exr", "$(pwd)/x.exr", "`pwd`/x.exr", "$env:SHOT/x.exr", "!SHOT!/x.exr", "~/render v2/x.####.exr"),
        *("[getenv SHOT]/x.exr", "a/[value root.name].exr", "${SHOT:-x}/a.exr"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="some are paths there")
def test_what_only_a_shell_or_windows_understands_is_refused_with_a_hint(name: str) -> None:
    for call in (lambda: checked(name, Settings()), lambda: Sequence(name), lambda: read_image(name)):
        with pytest.raises(CommandError) as caught:
            call()
        assert caught.value.code == "bad-path"
        assert caught.value.hint


@pytest.mark.parametrize(
    "name",
    [
        "~x.exr",
        "a~/x.exr",
        "cash$.exr",
        "a.$F4.exr",
        "a.$F.exr",
        "100%done.exr",
        "a.%04d.exr",
        "wow!.exr",
        "a!b.exr",
        "[v2].exr",
        "take(1).exr",
        "take:1.exr",
        "file.exr",
    ],
)
def test_names_that_mean_themselves(name: str) -> None:
    refuse_shell_words(name)


def test_a_file_that_has_the_very_name_is_read(tmp_path: Path) -> None:
    (tmp_path / "$SHOT.exr").write_text("x")
    refuse_shell_words(str(tmp_path / "$SHOT.exr"))


def test_the_hint_tells_the_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/me")
    with pytest.raises(CommandError, match=r"/home/me/x\.png"):
        refuse_shell_words("~/x.png")
