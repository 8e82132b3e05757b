"""Photographs are turned upright by their Orientation; an EXR never is."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from flowabs_nodes.image import Window
from flowabs_nodes.io.read import read_image
from tests.io.files import (
    colors,
    exr,
    flat,
    planes,
    srgb_to_linear,
)


def test_a_photograph_lying_on_its_side(tmp_path: Path) -> None:
    codes = np.arange(2 * 3 * 3, dtype=np.uint8).reshape(2, 3, 3) * 10
    turned = {
        1: codes,
        3: codes[::-1, ::-1],
        6: np.rot90(codes, -1),
        8: np.rot90(codes, 1),
        2: codes[:, ::-1],
        4: codes[::-1],
    }
    turned |= {5: codes.swapaxes(0, 1), 7: codes[::-1, ::-1].swapaxes(0, 1)}
    for orientation, upright in turned.items():
        image = read_image(flat(tmp_path / f"o{orientation}.tif", codes, Orientation=orientation))
        np.testing.assert_allclose(image.pixels, srgb_to_linear(upright / 255), atol=1e-6)
        assert image.spec.get_int_attribute("Orientation", 1) == 1
        assert image.data_window == image.display_window == Window(0, 0, upright.shape[1], upright.shape[0])
    path = exr(tmp_path / "o.exr", planes(colors()), Orientation=6)  # in an EXR it is only an attribute
    assert read_image(path).pixels.shape == (24, 32, 3)
