"""A file is whole only if every tile of every part decodes."""

from __future__ import annotations

from pathlib import Path

import OpenEXR

from flowabs_nodes.io.formats.png import PNG
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.io.verify import is_whole
from tests.io.files import (
    colors,
    exr,
    parts,
    planes,
)


def test_is_whole_looks_at_every_tile_and_part(tmp_path: Path) -> None:
    tiles = OpenEXR.TileDescription()
    tiles.xSize = tiles.ySize = 64
    tiled = exr(tmp_path / "a.exr", planes(colors(300, 150)), type=OpenEXR.tiledimage, tiles=tiles)
    parted = parts(
        tmp_path / "b.exr", ("one", planes(colors(600, 20)), {}), ("two", planes(colors(600, 20, seed=2)), {})
    )
    for path in (tiled, parted):
        assert is_whole(path)
        assert not is_whole(path, format=PNG)
        assert not is_whole(path, Settings(max_pixels=10_000))
        path.write_bytes(path.read_bytes()[:-1])
        assert not is_whole(path)
