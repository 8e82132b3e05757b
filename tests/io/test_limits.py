"""A picture that is too large is refused, whether it is read or written; the hint says how to raise the limit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.io.limits import check_display_window, check_readable, too_large
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from tests.io.files import exr, windowed


def test_what_is_read_has_a_limit_in_pixels_and_in_values(tmp_path: Path) -> None:
    path = windowed(tmp_path / "plate.exr")
    read_image(path, settings=Settings(max_pixels=32 * 24))
    with pytest.raises(ReadError, match="32x24 is more than 767 pixels") as caught:
        read_image(path, settings=Settings(max_pixels=32 * 24 - 1))
    assert caught.value.code == "too-large"
    many = {f"c{i:02}": np.zeros((4, 4), np.float16) for i in range(20)}
    with pytest.raises(ReadError, match="20 channels are too many"):
        read_data(exr(tmp_path / "many.exr", many), settings=Settings(max_pixels=16))


@pytest.mark.parametrize("size", [(0, 5, 1), (5, 0, 1), (5, 5, 2)])
def test_no_picture_at_all(size: tuple[int, int, int]) -> None:
    spec = oiio.ImageSpec(size[0], size[1], 3, "half")
    spec.depth = size[2]
    with pytest.raises(ReadError, match="not a picture"):
        check_readable("a.exr", spec, 3, Settings())


def test_what_is_written_has_the_same_limit() -> None:
    settings = Settings(max_pixels=100)
    assert not too_large(10, 10, settings)
    assert too_large(101, 1, settings)
    check_display_window(10, 10, settings)
    with pytest.raises(WriteError, match="11x10 is too large") as caught:
        check_display_window(11, 10, settings)
    assert caught.value.code == "too-large"
