"""A root that nobody gets out of, while a thread turns a link out of it and back as fast as it can."""

import os
import threading
import time
from contextlib import contextmanager, suppress

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import CommandError, FlowabsError, ReadError
from flowabs_nodes.io import confined
from flowabs_nodes.io.claim import claim
from flowabs_nodes.io.confined import held_file, held_folder
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings

pytestmark = pytest.mark.skipif(not confined.HOLDS, reason="only Linux opens again what is open")
SECONDS = 1.5


@pytest.fixture
def places(tmp_path):
    """Folders root/inner and outside, each with a picture p.exr, of 0.25 and of 8; links to the inner ones."""
    for folder, value in (("root/inner", 0.25), ("outside", 8.0)):
        (tmp_path / folder).mkdir(parents=True)
        image = oiio.ImageBuf(oiio.ImageSpec(8, 6, 3, "half"))
        image.set_pixels(image.roi, np.full((6, 8, 3), value, np.float32))
        assert image.write(str(tmp_path / folder / "p.exr"))
    (tmp_path / "root/shot").symlink_to("inner")
    (tmp_path / "root/q.exr").symlink_to("inner/p.exr")
    return tmp_path


@contextmanager
def turning(link, target):
    """Have a thread turn a link to ``target`` and to where it leads now, until the end."""
    over = threading.Event()
    new, inner = link.with_name(f"{link.name}.new"), os.readlink(link)
    turns = []

    def turn():
        while not over.is_set():
            for each in (target, inner):
                new.symlink_to(each)
                new.replace(link)
            turns.append(1)

    thread = threading.Thread(target=turn)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
    assert len(turns) > 10


def many(act):
    """Call ``act`` for a while; return how often it ended well, and how often each code was raised."""
    done, codes = 0, set()
    end = time.monotonic() + SECONDS
    while time.monotonic() < end:
        try:
            act()
            done += 1
        except FlowabsError as error:
            codes.add(error.code)
    return done, codes


@pytest.mark.parametrize(("path", "link", "target"), [("shot/p.exr", "shot", ""), ("q.exr", "q.exr", "p.exr")])
def test_what_is_read_is_from_within(places, path, link, target):
    root = places / "root"

    def read():
        assert read_image(root / path, settings=Settings(root=root)).pixels.max() == 0.25

    with turning(root / link, places / "outside" / target):
        done, codes = many(read)
    assert done > 0
    assert codes <= {"outside-root"}


def test_what_is_written_is_within(places):
    root, outside = places / "root", places / "outside"
    before = {name: (outside / name).stat().st_mtime_ns for name in os.listdir(outside)}

    def write():
        with claim(root / "shot/new.exr", root=root) as held:
            held.write(b"content")
            held.publish()

    with turning(root / "shot", outside):
        done, _ = many(write)
    assert done > 0
    assert {name: (outside / name).stat().st_mtime_ns for name in os.listdir(outside)} == before
    assert (root / "shot/new.exr").read_bytes() == b"content"


def test_folders_are_made_within(places):
    root, outside = places / "root", places / "outside"
    made = []

    def make():
        with suppress(OSError), held_folder(root / f"shot/a/{len(made)}/b", root) as folder:
            made.append(folder)

    with turning(root / "shot", outside):
        many(make)
    assert made
    assert os.listdir(outside) == ["p.exr"]


def test_what_is_held_stays_the_same(places):
    root = places / "root"
    with held_file(root / "shot/p.exr", root) as file, held_folder(root / "shot", root) as folder:
        (root / "inner").rename(root / "moved")
        (root / "inner").symlink_to(places / "outside")
        assert os.path.samefile(file, root / "moved/p.exr")
        (folder / "new").write_text("new")
    assert (root / "moved/new").exists()


def test_what_leads_outside_is_refused(places):
    root = places / "root"
    (root / "link").symlink_to(places / "outside")
    with pytest.raises(CommandError, match="outside"), held_file(root / "link/p.exr", root):
        pass
    with pytest.raises(CommandError, match="outside"), held_folder(root / "link/new", root):
        pass
    assert os.listdir(places / "outside") == ["p.exr"]


def test_without_a_root_paths_stay_what_they_are(places):
    with held_file(places / "none.exr", None) as file, held_folder(places / "a/b", None) as folder:
        assert file == str(places / "none.exr")
        assert folder == places / "a/b"
    assert folder.is_dir()


def test_messages_name_the_file_and_not_what_is_open(places):
    path = places / "root/inner/p.exr"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(ReadError) as failure:
        read_image(path, settings=Settings(root=places / "root"))
    assert failure.value.file == str(path)
    assert "/proc" not in str(failure.value)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ReadError) as failure:
        read_image(path, settings=Settings(root=places / "root"))
    assert "/proc" not in str(failure.value)
