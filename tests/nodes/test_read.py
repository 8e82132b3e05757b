from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.read import READ, READ_AOV
from tests.io.files import colors, exr, parts, planes


def test_parameters_and_defaults() -> None:
    expected = {
        "layer": "",
        "part": "",
        "colorspace": "auto",
        "alpha": "auto",
        "nonfinite": "repair",
        "missing": "error",
    }
    assert READ.defaults() == expected
    assert READ_AOV.defaults() == {"layer": "", "part": "", "missing": "error"}
    for node in (READ, READ_AOV):
        assert node.file_param is not None
        assert node.file_param.role == "input"
        assert not node.all_params["missing"].in_key  # another frame's content is in the key
        assert node.inputs == ()


@pytest.mark.parametrize("value", [0, 3, "", "rgba_left", "2"])
def test_parts(value: Any) -> None:
    assert READ.all_params["part"].problem(value) is None


@pytest.mark.parametrize("value", [-1, 1.0, True, None, ["a"]])
def test_no_parts(value: Any) -> None:
    assert READ.all_params["part"].problem(value) == ("bad-value", "the name of a part, or its number from 0")


def test_run(tmp_path: Path) -> None:
    depth = np.full((24, 32), 7.5, np.float32)
    path = parts(
        tmp_path / "a.exr", ("left", planes(colors()), {}), ("right", planes(colors(seed=2)) | {"Z": depth}, {})
    )
    notes: list[str] = []
    context = Context(note=notes.append, services=Settings())
    image = READ.run(context, file=str(path), **READ.defaults() | {"part": "right"})
    np.testing.assert_array_equal(image.pixels, colors(seed=2).astype(np.float32))  # type: ignore[union-attr]
    assert any("colour space" in note for note in notes)
    data = READ_AOV.run(context, file=str(path), **READ_AOV.defaults() | {"layer": "Z"})
    assert (data.type, data.channels) == ("data", ("Z",))  # type: ignore[union-attr]
    np.testing.assert_array_equal(data.pixels[..., 0], depth)  # type: ignore[union-attr]


def test_limits_come_from_the_run(tmp_path: Path) -> None:
    path = exr(tmp_path / "a.exr", planes(colors()))
    for node in (READ, READ_AOV):
        with pytest.raises(ReadError, match="more than 100 pixels"):
            node.run(Context(services=Settings(max_pixels=100)), file=str(path), **node.defaults())
