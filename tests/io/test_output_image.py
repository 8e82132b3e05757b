"""A frame to save takes only options that there are."""

from __future__ import annotations

import pytest

from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from tests.io.files import (
    colors,
)


def test_wrong_options() -> None:
    image = Image.from_array(colors())
    with pytest.raises(ValueError, match="data_type"):
        build_picture(image, data_type="double")
    with pytest.raises(ValueError, match="compression"):
        build_picture(image, compression="lzw")
