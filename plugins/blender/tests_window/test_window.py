"""In a window: what is drawn, edited and undone; a run that goes on beside it, and ends with Esc; a live preview."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

Window = Callable[..., dict[str, Any]]


def test_a_graph_is_drawn_edited_and_undone(window: Window, tmp_path: Path) -> None:
    told = window("edit", picture=tmp_path / "edit.png")
    assert told["added"]
    assert told["undone"]
