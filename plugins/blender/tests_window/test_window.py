"""In a window: what is drawn, edited and undone; runs that go on beside it, and end with Esc; a live preview."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest
from conftest import CHECKOUT

PLATE = CHECKOUT / "docs" / "pictures" / "coffee.exr"

Window = Callable[..., dict[str, Any]]


def test_a_graph_is_drawn_edited_and_undone(window: Window, tmp_path: Path) -> None:
    told = window("edit", picture=tmp_path / "edit.png")
    assert told["added"]
    assert told["undone"]


def test_the_picture_of_the_docs(blender: Callable[..., str], tmp_path: Path) -> None:
    picture = tmp_path / "docs.png"
    blender(CHECKOUT / "plugins" / "blender" / "screenshot.py", "abstraction", str(picture))
    pixels = oiio.ImageBuf(str(picture)).get_pixels(oiio.UINT8)
    assert pixels.shape[:2] == (720, 1280), "the whole window"
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 500


def test_a_run_goes_on_beside_the_window_and_ends_with_escape(window: Window, tmp_path: Path) -> None:
    told = window("cancel", picture=tmp_path / "cancel.png")
    assert told["at_work"]
    assert told["longest_gap"] < 1, "Blender has to answer meanwhile"
    assert told["seconds"] < 1
    assert told["results"] == []


def test_a_sequence_is_run_and_ended(window: Window, tmp_path: Path) -> None:
    for frame in range(1, 301):
        (tmp_path / f"shot.{frame:04}.exr").symlink_to(PLATE)
    told = window("sequence", folder=tmp_path)
    assert len(list(tmp_path.glob("whole.*.png"))) == 3
    assert told["shown"] == "whole.0001.png"
    assert told["ended_seconds"] < 1
    made = list(tmp_path.glob("ended.*.png"))
    assert 0 < len(made) < 300
    for file in made:
        assert not oiio.ImageBuf(str(file)).has_error, f"{file.name} is not whole"


def test_a_slider_is_dragged_and_the_preview_follows(window: Window, tmp_path: Path) -> None:
    told = window("preview", plate=PLATE, picture=tmp_path / "preview.png")
    assert told["problem"] == ""
    assert told["shown"] == "abstraction preview"
    before, after = told["moved"]
    assert before == pytest.approx(1)
    assert after > 1.1
    assert told["while_dragged"] >= 2, "the preview has to follow before the mouse is let go"
    assert told["longest_gap"] < 1, "Blender has to answer meanwhile"
    assert told["resting_after"] < 5
