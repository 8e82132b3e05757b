import numpy as np
import pytest

from flowabs_nodes import color
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.nodes.declare import Context
from flowabs_nodes.nodes.matte import MATTE

RGBA = np.random.default_rng(0).random((5, 7, 4)).astype(np.float32)


def matte(image, **params):
    result = call_node(MATTE, Context(), {"image": image}, params)["matte"]
    assert result.type == "matte"
    return result.pixels[..., 0]


def test_by_default_alpha_else_luminance_else_the_only_channel():
    np.testing.assert_array_equal(matte(Image.from_array(RGBA)), RGBA[..., 3])
    rgb = Image.from_array(RGBA[..., :3])
    np.testing.assert_allclose(matte(rgb), color.luminance(RGBA[..., :3], "lin_rec709"), atol=1e-6)
    np.testing.assert_array_equal(matte(Image.from_array(RGBA[..., 0])), RGBA[..., 0])
    depth = Image.from_array(RGBA[..., :1], type="data", channels=("Z",))
    np.testing.assert_array_equal(matte(depth), RGBA[..., 0])


def test_low_becomes_0_and_high_1_either_way_round():
    depth = Image.from_array(np.array([[0, 10, 20, 30, 1e10]]), type="data", channels=("Z",))
    np.testing.assert_allclose(matte(depth, low=10, high=30)[0], [0, 0, 0.5, 1, 1])
    np.testing.assert_allclose(matte(depth, low=30, high=10)[0], [1, 1, 0.5, 0, 0])
    np.testing.assert_allclose(matte(depth, low=20, high=20)[0], [0, 0, 1, 1, 1])


def test_named_channels_and_their_mistakes():
    normals = Image.from_array(RGBA[..., :3], type="data", channels=("N.X", "N.Y", "N.Z"))
    np.testing.assert_array_equal(matte(normals, channel="N.Y"), RGBA[..., 1])
    np.testing.assert_array_equal(matte(Image.from_array(RGBA), channel="G"), RGBA[..., 1])
    np.testing.assert_array_equal(matte(normals), RGBA[..., 0])
    with pytest.raises(FlowabsError, match=r"no channel 'N\.W'.*did you mean"):
        matte(normals, channel="N.W")


def test_of_depth_and_of_large_ids():
    depth = Image.from_array(np.array([[2, 4, 1e10]]), type="depth")
    np.testing.assert_array_equal(matte(depth, low=2, high=6)[0], [0, 0.5, 1])
    ids = Image.from_array(np.array([[2**24, 2**24 + 1, 2**32 - 1]], np.uint32), type="id")
    np.testing.assert_array_equal(matte(ids, low=2**24 + 1, high=2**24 + 1)[0], [0, 1, 1])
