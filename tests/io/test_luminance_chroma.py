"""Files of luminance and subsampled chroma: OpenImageIO refuses them, the OpenEXR module reads but does not convert."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.write import build_picture, save
from tests.io.files import attributes, exr, luminance_chroma, raw_header

newer = pytest.mark.skipif(
    oiio.VERSION < 30100, reason="OpenImageIO 3.0 converts these itself, where windows are simple"
)

WEIGHTS = np.array([0.2126390058715103, 0.7151686787677559, 0.07219231536073371])  # of linear Rec.709


def split(rgb: np.ndarray) -> dict[str, tuple[np.ndarray, int]]:
    """Return Y, RY, BY of (H, W, 3), each with its sampling; chroma is taken, not filtered, at even x and y."""
    y = rgb @ WEIGHTS
    return {"Y": (y, 1), "RY": (((rgb[..., 0] - y) / y)[::2, ::2], 2), "BY": (((rgb[..., 2] - y) / y)[::2, ::2], 2)}


def smooth(height: int = 40, width: int = 50) -> np.ndarray:
    """Return (H, W, 3) of colour without detail, which survives the subsampling of chroma."""
    y, x = np.mgrid[:height, :width]
    return np.stack([1 + 0.5 * np.sin(x / 15), 1 + 0.3 * np.cos(y / 12), 1 + 0.4 * np.sin((x + y) / 20)], 2)


@newer
@pytest.mark.parametrize("corner", [(0, 0), (-4, 6)])
def test_becomes_rgb(tmp_path: Path, corner: tuple[int, int]) -> None:
    rgb = smooth()
    path = luminance_chroma(tmp_path / "yc.exr", split(rgb), corner)
    image = read_image(path)
    assert image.channels == ("R", "G", "B")
    assert (image.spec.x, image.spec.y) == corner
    inside = (slice(14, -14), slice(14, -14))  # at the ends chroma is repeated
    np.testing.assert_allclose(image.pixels[inside], rgb[inside], atol=4e-3)
    np.testing.assert_allclose(image.pixels, rgb, atol=0.1)


@newer
def test_chroma_that_is_not_subsampled(tmp_path: Path) -> None:
    rgb = smooth(10, 12)
    y = rgb @ WEIGHTS
    planes = {"Y": y, "RY": (rgb[..., 0] - y) / y, "BY": (rgb[..., 2] - y) / y}
    image = read_image(exr(tmp_path / "yc.exr", {name: plane.astype(np.float32) for name, plane in planes.items()}))
    np.testing.assert_allclose(image.pixels, rgb, rtol=1e-5)


def test_grey_is_exact(tmp_path: Path) -> None:
    grey = np.repeat(np.linspace(0.1, 2, 12 * 10).reshape(12, 10, 1).astype(np.float16).astype(np.float64), 3, 2)
    image = read_image(luminance_chroma(tmp_path / "grey.exr", split(grey)))
    np.testing.assert_allclose(image.pixels, grey, rtol=2e-3)


def test_alpha_comes_along_and_metadata_goes_out_again(tmp_path: Path) -> None:
    channels = split(smooth(8, 8)) | {"A": (np.full((8, 8), 0.5), 1)}
    path = luminance_chroma(tmp_path / "yc.exr", channels)
    image = read_image(path)
    assert image.channels == ("R", "G", "B", "A")
    np.testing.assert_array_equal(image.pixels[..., 3], 0.5)
    save(build_picture(image), tmp_path / "out.exr")
    assert attributes(tmp_path / "out.exr")["PixelAspectRatio"] == ("float", 1.0)


def test_cut_short(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = luminance_chroma(tmp_path / "yc.exr", split(smooth()))
    path.write_bytes(path.read_bytes()[:-500])
    with pytest.raises(ReadError, match="damaged or cut short"):
        read_image(path)
    assert capfd.readouterr().out == ""  # the OpenEXR module prints there


@newer
def test_other_subsampled_channels_are_refused(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    path = luminance_chroma(tmp_path / "rgb.exr", {"R": (rng.random((8, 8)), 1), "G": (rng.random((4, 4)), 2)})
    with pytest.raises(ReadError, match="ubsampl"):
        read_image(path)
    path = luminance_chroma(
        tmp_path / "y4.exr",
        {name: (p[0][::2, ::2] if p[1] == 2 else p[0], p[1] ** 2) for name, p in split(smooth(8, 8)).items()},
    )
    with pytest.raises(ReadError, match="sampled every 4x4"):
        read_image(path)


@newer
def test_a_bomb_is_refused_by_its_size(tmp_path: Path) -> None:
    path = tmp_path / "bomb.exr"
    path.write_bytes(raw_header((0, 0, 9999, 9999), [("Y", 1, 1), ("RY", 2, 2), ("BY", 2, 2)]) + bytes(1000))
    with pytest.raises(ReadError, match="cannot be in a file this small"):
        read_image(path)
