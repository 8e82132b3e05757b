from __future__ import annotations

from typing import Any

import pytest

from flowabs_nodes.choices import COMPRESSIONS, DATA_TYPES
from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import Picture
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.write import WRITE
from tests.io.files import colors


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
