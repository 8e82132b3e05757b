from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flowabs_nodes.file_choices import COMPRESSIONS, DATA_TYPES
from flowabs_nodes.graph import parse_setting
from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import Picture
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.write import WRITE
from tests.io.files import colors, exr, planes


def test_parameters_and_defaults() -> None:
    assert WRITE.defaults() == {
        "data_type": "auto",
        "compression": "auto",
        "keep_layers": "",
        "colorspace": "plate",
        "display": "",
        "view": "",
        "metadata": {},
    }
    assert WRITE.all_params["data_type"].choices == DATA_TYPES
    assert WRITE.all_params["compression"].choices == COMPRESSIONS
    assert WRITE.outputs == ()
    assert WRITE.file_param is not None
    assert (WRITE.file_param.role, WRITE.file_param.in_key) == ("output", False)
    for name in ("image", "ink", "any_name"):
        port = WRITE.input(name)
        assert port is not None
        assert all(port.takes(kind) == kind for kind in ("color", "mono", "matte", "flow", "data"))


@pytest.mark.parametrize("value", [{}, {"Copyright": "me", "take": 3, "gain": 0.5}])
def test_metadata(value: Any) -> None:
    assert WRITE.all_params["metadata"].problem(value) is None


@pytest.mark.parametrize(
    "value",
    [[], "a", None, {"a": None}, {"a": True}, {"a": [1]}, {"a": float("inf")}, {"channels": "x"}, {"": "x"}, {1: "x"}],
)
def test_bad_metadata(value: Any) -> None:
    wrong = WRITE.all_params["metadata"].problem(value)
    assert wrong is not None
    assert wrong[0] == "bad-value"
    assert "attribute names" in wrong[1]


def test_run_hands_over_a_picture() -> None:
    image = Image.from_array(colors())
    settings = Settings(max_pixels=5000)
    context = Context(services=settings)
    result = WRITE.run(context, image=image, ink=image, file="out.exr", **WRITE.defaults() | {"metadata": {"take": 1}})
    picture = result["picture"]  # type: ignore[index]
    assert isinstance(picture, Picture)
    assert picture.image is image
    assert set(picture.layers) == {"ink"}
    assert picture.settings is settings
    assert picture.metadata == {"take": 1}


def notes_of(image: Image, file: str, **params: Any) -> list[str]:
    """Return what the node says of a picture that it hands over for a file."""
    said: list[str] = []
    context = Context(node="out", note=said.append, services=Settings())
    WRITE.run(context, image, file=file, **(WRITE.defaults() | params))
    return said


def test_layers_left_out_are_said_with_what_keeps_them(tmp_path: Path) -> None:
    shape = (4, 5)
    channels = {"Z": np.ones(shape, np.float32), "N.X": np.ones(shape, np.float32)} | {
        f"a{number}.R": np.ones(shape, np.float32) for number in range(7)
    }
    image = read_image(exr(tmp_path / "plate.exr", planes(colors(*shape)) | channels))
    (said,) = notes_of(image, "out.####.exr")
    assert "left out: " in said
    assert "and 3 more" in said
    assert "--set out.keep_layers='*' keeps all" in said
    assert parse_setting('"*"') == "*"
    assert not notes_of(image, "out.####.exr", keep_layers="*")
    assert not notes_of(image, "out.png"), "a PNG has no layers"
    assert not notes_of(read_image(exr(tmp_path / "rgb.exr", planes(colors(*shape)))), "out.exr")
