"""Key and graph in a file: found again, and never handed on to the next file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR

from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.provenance import stored_key
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.write import save
from tests.io.files import (
    colors,
    exr,
    flat,
    planes,
    windowed,
    written,
)


def test_the_stamps_of_another_run_do_not_stay(tmp_path: Path) -> None:
    first, _ = written(read_image(windowed(tmp_path / "plate.exr")), tmp_path / "first.exr")
    image = read_image(first)
    save(build_picture(image), tmp_path / "second.exr", key="other")
    assert stored_key(first) == "the key"
    assert stored_key(tmp_path / "second.exr") == "other"
    header = OpenEXR.File(str(tmp_path / "second.exr"), header_only=True).header()
    assert "flowabs:graph" not in header


def test_stored_key_of_other_files(tmp_path: Path) -> None:
    assert stored_key(tmp_path / "none.exr") is None
    (tmp_path / "text.exr").write_text("hello")
    assert stored_key(tmp_path / "text.exr") is None
    assert stored_key(exr(tmp_path / "a.exr", planes(colors()))) is None
    assert (
        stored_key(flat(tmp_path / "a.tif", np.zeros((2, 2, 3), np.uint8), ImageDescription="my flowabs:key=no"))
        is None
    )
