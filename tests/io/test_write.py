"""Whatever happens, there is a whole frame at the final name, or what was there before."""

from __future__ import annotations

import dataclasses
import errno
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import CommandError, FlowabsError, WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io import write
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.write import Picture, build_picture, is_whole, save, stored_key
from tests.io.files import colors, exr, planes

NAMES = ["out.exr", "out.png", "out.tif"]


@pytest.fixture
def picture() -> Picture:
    return build_picture(Image.from_array(colors().astype(np.float32)))


@pytest.mark.parametrize("name", NAMES)
def test_save(tmp_path: Path, picture: Picture, name: str) -> None:
    path = tmp_path / "a" / "b" / name
    save(picture, path, key="k" * 64, graph='{"nodes": {}}')
    assert is_whole(path)
    assert stored_key(path) == "k" * 64
    assert os.listdir(path.parent) == [name]
    save(picture, path, key="again")
    assert stored_key(path) == "again"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("existing", [True, False])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO])
def test_disk_full(
    tmp_path: Path, picture: Picture, name: str, existing: bool, number: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / name
    if existing:
        save(picture, path, key="old")
    written = 0
    plain = os.write

    def full(fd: int, data: Any) -> int:
        nonlocal written
        if written > 500:
            raise OSError(number, os.strerror(number))
        written += 400
        return plain(fd, bytes(data)[:400])

    monkeypatch.setattr(os, "write", full)
    with pytest.raises(WriteError) as caught:
        save(picture, path, key="new")
    assert caught.value.code == ("disk-full" if number == errno.ENOSPC else "write-failed")
    assert caught.value.file == str(path)
    assert os.listdir(tmp_path) == ([name] if existing else [])
    assert stored_key(path) == ("old" if existing else None)


@pytest.mark.parametrize("name", NAMES)
def test_a_write_that_lies_is_found_out(
    tmp_path: Path, picture: Picture, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The disk keeps other bytes than it was given: of an uncompressed EXR, they may well decode."""
    picture = dataclasses.replace(picture, compression="none")
    plain = os.write
    monkeypatch.setattr(os, "write", lambda fd, data: plain(fd, bytes(data)[:700] + bytes(max(0, len(data) - 700))))
    with pytest.raises(WriteError, match="cannot be read back") as caught:
        save(picture, tmp_path / name)
    assert caught.value.code == "not-whole"
    assert os.listdir(tmp_path) == []


def test_a_full_disk_for_real(tmp_path: Path) -> None:
    """Every shortfall of a file size limit is noticed, whichever byte is the first that does not fit."""
    pytest.importorskip("resource")
    code = """
import os, resource, signal, sys
import numpy as np
from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io.write import build_picture, save, is_whole
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
picture = build_picture(Image.from_array(np.random.default_rng(0).random((40, 60, 3), np.float32)))
path = sys.argv[1]
save(picture, path)
size = os.path.getsize(path)
os.unlink(path)
for short in (1, 2, 8, 50, 400, size // 2, size - 400, size - 8, size):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size - short, resource.RLIM_INFINITY))
    try:
        save(picture, path)
        print("silent", short)
    except WriteError:
        pass
    if os.listdir(os.path.dirname(path)):
        print("left", short)
print("done")
"""
    folder = tmp_path / "limited"
    folder.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder / "out.exr")], capture_output=True, text=True, timeout=60
    )
    assert done.stdout == "done\n", done.stderr


def test_interrupted(tmp_path: Path, picture: Picture, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(write, "is_whole", interrupt)
    with pytest.raises(KeyboardInterrupt):
        save(picture, tmp_path / "out.exr")
    assert os.listdir(tmp_path) == []


def test_killed_in_the_middle(tmp_path: Path, picture: Picture) -> None:
    """At every moment the final name is absent or whole; the next run sweeps what the dead one left."""
    code = """
import sys
import numpy as np
from flowabs_nodes.image import Image
from flowabs_nodes.io.write import build_picture, save
picture = build_picture(Image.from_array(np.random.default_rng(0).random((400, 600, 3), np.float32)))
print("go", flush=True)
while True:
    save(picture, sys.argv[1], key="killed")
"""
    path = tmp_path / "out.exr"
    for delay in (0.0, 0.01, 0.03, 0.07):
        process = subprocess.Popen([sys.executable, "-c", code, str(path)], stdout=-1, text=True)
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(delay)
        process.kill()
        process.wait()
        process.stdout.close()
        assert not path.exists() or is_whole(path)
    save(picture, path, key="after")
    assert os.listdir(tmp_path) == ["out.exr"]
    assert stored_key(path) == "after"


def test_formats_that_are_not_written(tmp_path: Path, picture: Picture) -> None:
    for name, reason in (
        ("a.jpg", "JPEG is read only"),
        ("a.dpx", "DPX is read only"),
        ("a.cin", "not a picture format"),
        ("a", "not a picture format"),
    ):
        with pytest.raises(WriteError, match=f"{reason}.*use exr, png, tif or tiff") as caught:
            save(picture, tmp_path / name)
        assert caught.value.code == "bad-format"
    assert os.listdir(tmp_path) == []


def test_root(tmp_path: Path, picture: Picture) -> None:
    root = tmp_path / "root"
    root.mkdir()
    (root / "link").symlink_to(tmp_path)
    for path in (tmp_path / "out.exr", root / "link" / "out.exr", root / ".." / "out.exr"):
        with pytest.raises(CommandError):
            save(picture, path, settings=Settings(root=root))
    save(picture, root / "out.exr", settings=Settings(root=root))


def test_an_error_names_the_file(tmp_path: Path) -> None:
    with pytest.raises(FlowabsError) as caught:
        save(build_picture(Image.from_array(colors()), colorspace="nonsense"), tmp_path / "out.exr")
    assert caught.value.file == str(tmp_path / "out.exr")
    assert os.listdir(tmp_path) == []


def test_the_same_bytes_each_time(tmp_path: Path) -> None:
    """A file says when its plate was taken, never when it was written."""
    pictures = {}
    for dated in (False, True):
        header = {"capDate": "2004:01:04 18:10:00"} if dated else {}
        pictures[dated] = build_picture(read_image(exr(tmp_path / f"plate{dated}.exr", planes(colors()), **header)))
    for folder in ("first", "a second later"):
        for dated, picture in pictures.items():
            for name in NAMES:
                save(picture, tmp_path / folder / str(dated) / name, key="k")
        if folder == "first":
            time.sleep(1.1)
    for dated in pictures:
        for name in NAMES:
            made = (tmp_path / "first" / str(dated) / name).read_bytes()
            assert made == (tmp_path / "a second later" / str(dated) / name).read_bytes(), name
            assert (b"2004:01:04 18:10:00" in made) == dated, name
            assert time.strftime("%Y:%m:%d").encode() not in made, name
