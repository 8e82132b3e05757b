import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from tools.gallery.sheet import GAP, Tile, display, enlarged, fitted, save, sheet, wrapped


def panel(value=128, height=40, width=60):
    return np.full((height, width, 3), value, np.uint8)


def test_panels_stand_in_rows_with_their_words_below():
    made = sheet([[Tile(panel(10), "(a) One"), Tile(panel(20), "(b) Two", "sigma 1")], [Tile(panel(30), "(c) Three")]])
    assert made.shape[1] == 3 * GAP + 2 * 60
    assert (made[GAP : GAP + 40, GAP : GAP + 60] == 10).all()
    assert (made[GAP : GAP + 40, 2 * GAP + 60 : 2 * GAP + 120] == 20).all()
    assert (made[GAP + 41 : GAP + 80, GAP : GAP + 60] < 128).any()  # text
    assert (made[-GAP:] == 255).all()


def test_a_white_panel_gets_a_frame():
    made = sheet([[Tile(panel(255), "")]])
    assert (made[GAP, GAP : GAP + 60] == 200).all()
    assert (made[GAP + 1 : GAP + 39, GAP + 1 : GAP + 59] == 255).all()


def test_long_words_wrap():
    lines = wrapped("one two three four five six seven", 80)
    assert len(lines) > 1
    assert " ".join(lines) == "one two three four five six seven"
    assert wrapped("", 80) == []


def test_fitted_never_enlarges_and_keeps_the_shape():
    assert fitted(panel(), 100) is not None
    assert fitted(panel(), 100).shape == (40, 60, 3)
    assert fitted(panel(), 30).shape == (20, 30, 3)


def test_enlarged_repeats_pixels():
    ramp = np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    assert (enlarged(ramp, (1, 2, 2, 1), 3)[2, 5] == ramp[2, 2]).all()
    assert enlarged(ramp, (1, 2, 2, 1), 3).shape == (3, 6, 3)


def test_display_encodes_colour_and_leaves_a_matte():
    half = np.full((2, 2, 3), 0.5, np.float32)
    assert (display(Image.from_array(half)) == 188).all()  # sRGB of 0.5
    assert (display(Image.from_array(half[..., :1], type="matte")) == 128).all()
    straight = np.zeros((1, 1, 4), np.float32)
    assert (display(Image.from_array(straight)) == 255).all()  # nothing, over white


def test_small_sheets_are_png_large_ones_jpeg_and_none_too_large(tmp_path):
    noise = np.random.default_rng(0).integers(0, 255, (200, 200, 3)).astype(np.uint8)
    assert save(panel(), tmp_path / "a.png").suffix == ".png"
    file = save(noise, tmp_path / "a.png", limit=40_000)
    assert file.suffix == ".jpg"
    assert file.stat().st_size <= 40_000
    assert not (tmp_path / "a.png").exists()  # the sheet of before is gone
    assert oiio.ImageBuf(str(file)).spec().width == 200
    with pytest.raises(WriteError):
        save(noise, tmp_path / "a.png", limit=1000)
