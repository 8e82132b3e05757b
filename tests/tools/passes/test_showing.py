"""Contact sheets and animations, and the commands that make them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

from tests.io.files import exr, planes
from tools.passes.__main__ import main
from tools.passes.showing import animation


@pytest.fixture
def shot(tmp_path: Path) -> str:
    """Write four frames of a grey square that moves by 4 pixels, with depth and motion; return their pattern."""
    motion = np.broadcast_to(np.float32([-4, 0, -4, 0]), (24, 32, 4))
    for frame in (1, 2, 3, 4):
        rgb = np.full((24, 32, 3), 0.9, np.float32)
        rgb[8:16, 4 * frame : 4 * frame + 8] = 0.1
        passes = planes(rgb) | {"Z": np.ones((24, 32), np.float32)} | planes(motion.copy(), "XYZW", "motion")
        exr(tmp_path / f"shot.{frame:04d}.exr", passes)
    return str(tmp_path / "shot.####.exr")


def frames_of(path: Path) -> list[np.ndarray]:
    """Return the frames of a GIF as a browser shows them: what is transparent is as it was."""
    file, found = oiio.ImageInput.open(str(path)), []
    while file.seek_subimage(len(found), 0):
        pixels = file.read_image("uint8")
        before = found[-1] if found else pixels[..., :3]
        found.append(np.where(pixels[..., 3:] == 255, pixels[..., :3], before))
    return found


def test_an_animation_plays_its_frames(tmp_path: Path) -> None:
    frames = [np.full((6, 8, 3), shade, np.uint8) for shade in (0, 100, 255)]
    path = animation(frames, tmp_path / "new" / "a.gif", 12, 320)
    for expected, found in zip(frames, frames_of(path), strict=True):
        np.testing.assert_array_equal(found, expected)
    frames, seconds = oiio.ImageBuf(str(path)).spec().getattribute("FramesPerSecond")
    assert frames / seconds == pytest.approx(12, abs=0.5)  # a GIF counts hundredths of a second


def test_frames_share_their_colours(tmp_path: Path) -> None:
    ramp = np.linspace(0, 255, 64).astype(np.uint8)[None, :, None].repeat(8, 0).repeat(3, 2)
    path = animation([ramp, 255 - ramp], tmp_path / "a.gif", 12, 320, colors=4)
    colors = np.unique(np.concatenate([frame.reshape(-1, 3) for frame in frames_of(path)]), axis=0)
    assert 2 <= len(colors) <= 4


def test_the_commands(shot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sheet", shot, str(tmp_path / "sheet.png"), "--columns", "2", "--width", "16"]) == 0
    sheet = oiio.ImageBuf(str(tmp_path / "sheet.png")).spec()
    assert sheet.width == 2 * 16 + 3 * 12
    assert main(["animate", shot, str(tmp_path / "a.gif"), "--frames", "2-3"]) == 0
    assert len(frames_of(tmp_path / "a.gif")) == 2
    capsys.readouterr()
    assert main(["boil", shot, shot]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "  mean 0.0000 of the ink"
    assert main(["change", shot, shot, "--alone", shot, "--sheet", str(tmp_path / "d.png")]) == 0
    mean, sheet_file = capsys.readouterr().out.splitlines()[-2:]
    assert mean == "  mean 0.0000 ghost 0.0000 of the ink"
    assert Path(sheet_file).is_file()


def test_frames_that_are_not_there(shot: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sheet", shot.replace("shot", "shut"), "a.png"]) == 2
    assert "there are no frames of this sequence" in capsys.readouterr().err
    assert main(["change", shot, shot, "--frames", "2,4"]) == 2
    assert "two frames in a row" in capsys.readouterr().err
