"""A run touches no file outside its root, and takes no name that a file cannot have."""

from __future__ import annotations

from pathlib import Path

import pytest

from flowabs_nodes.errors import CommandError
from flowabs_nodes.io.settings import Settings, checked, within


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


@pytest.mark.parametrize("name", ["", "a\0b.exr", "file:///etc/x.exr", "http://x/y.exr"])
def test_names_no_file_has(name: str) -> None:
    with pytest.raises(CommandError) as caught:
        checked(name, Settings())
    assert caught.value.code == "bad-path"
