"""Several readers of one file decode it once, and read what they would read without the others."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

import flowabs_nodes as fa
from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import decode_exr, shared_decode
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth, read_normal
from flowabs_nodes.io.shared_decode import shared_decodes
from tests.io import renders
from tests.io.files import same_bits

READERS: tuple[Callable[..., Any], ...] = (read_image, read_depth, read_normal, read_motion, read_id)


@pytest.fixture
def decoded(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, ...]]:
    """Return the channels of each decoding for several readers, which fills up."""
    seen: list[tuple[str, ...]] = []
    decode = decode_exr.decode_exr

    def counted(place: str, spec: Any, names: tuple[str, ...]) -> Any:
        seen.append(tuple(names))
        return decode(place, spec, names)

    monkeypatch.setattr(decode_exr, "decode_exr", counted)
    return seen


@pytest.fixture
def render(tmp_path: Path) -> str:
    return str(renders.blender45(tmp_path / "a.exr"))


def pixels(read: Any) -> list[np.ndarray]:
    """Return the pixels of what a reader returns."""
    return [each.pixels for each in (read if isinstance(read, tuple) else (read,))]


def test_readers_of_one_file_read_the_same_from_one_decoding(render: str, decoded: list[tuple[str, ...]]) -> None:
    alone = [pixels(read(render)) for read in READERS]
    assert not decoded
    with shared_decodes({render: [partial(read, render) for read in READERS]}):
        together = [pixels(read(render)) for read in READERS]
        assert len(decoded) == 1
        assert not shared_decode._shares.get()[render]._planes  # the last reader took the last
    for expected, found in zip(alone, together, strict=True):
        assert all(map(same_bits, found, expected))


def test_a_channel_that_two_read_is_kept_for_the_second(render: str, decoded: list[tuple[str, ...]]) -> None:
    read = partial(read_data, render, layer="ViewLayer.Depth.Z")
    with shared_decodes({render: [read, partial(read_depth, render)]}):
        np.testing.assert_array_equal(read().pixels[..., 0], renders.depth())
        assert shared_decode._shares.get()[render]._planes
        assert same_bits(read_depth(render).pixels, read_depth(render).pixels)  # the second of these from the file
    assert decoded == [("ViewLayer.Depth.Z",)]


def test_whoever_asks_for_more_reads_the_file_itself(render: str) -> None:
    with shared_decodes({render: [partial(read_depth, render), partial(read_normal, render)]}):
        read_depth(render)
        assert same_bits(read_motion(render).pixels, renders.VECTOR)


@pytest.mark.parametrize("readers", [(read_depth,), (read_depth, partial(read_normal, layer="nowhere"))])
def test_one_reader_shares_with_nobody(render: str, decoded: list[tuple[str, ...]], readers: Any) -> None:
    with shared_decodes({render: [partial(read, render) for read in readers]}):
        read_depth(render)
        with pytest.raises(ReadError, match="nowhere"):
            read_normal(render, layer="nowhere")
    assert not decoded


def test_parts_are_compressed_apart(tmp_path: Path, decoded: list[tuple[str, ...]]) -> None:
    render = str(renders.blender5(tmp_path / "a.exr"))
    with shared_decodes({render: [partial(read_depth, render), partial(read_normal, render)]}):
        np.testing.assert_array_equal(read_depth(render).pixels[..., 0], renders.depth())
    assert not decoded


def test_a_file_that_is_replaced_is_read_again(render: str) -> None:
    with shared_decodes({render: [partial(read_depth, render), partial(read_normal, render)]}):
        before = read_depth(render)
        renders.blender45(Path(render + ".new"))
        file = OpenEXR.File(render + ".new", separate_channels=True)
        normal = file.channels()["ViewLayer.Normal.X"].pixels
        normal[:] = 0.25
        file.write(render + ".new")
        os.replace(render + ".new", render)
        assert (read_normal(render).pixels[..., 0] == 0.25).all()
    assert same_bits(before.pixels, read_depth(render).pixels)


def test_a_damaged_file_is_told_of_as_ever(render: str) -> None:
    with open(render, "r+b") as file:
        file.truncate(os.path.getsize(render) // 2)
    with pytest.raises(ReadError) as alone:
        read_normal(render)
    readers = {render: [partial(read_depth, render), partial(read_normal, render)]}
    with shared_decodes(readers), pytest.raises(ReadError) as shared:
        read_normal(render)
    assert (shared.value.code, shared.value.message) == (alone.value.code, alone.value.message)


def test_a_run_decodes_each_frame_once(tmp_path: Path, decoded: list[tuple[str, ...]]) -> None:
    for frame in (1, 2):
        renders.blender45(tmp_path / f"shot.{frame:04d}.exr")
    nodes = {
        "plate": {"type": "read@1"},
        "depth": {"type": "read_depth@1"},
        "ids": {"type": "read_id@1"},
        "out": {"type": "write@1", "inputs": {"image": "plate", "z": "depth", "c": "ids.coverage"}},
    }
    document = {"format": "flowabs.graph/1", "name": "passes", "nodes": nodes}
    report = fa.run(document, input=tmp_path / "shot.####.exr", output=tmp_path / "out.####.exr")
    assert [frame.status for frame in report.frames] == ["done", "done"]
    assert len(decoded) == 2
    assert not shared_decode._shares.get()
