"""Conversion between scene-linear spaces, and what is told to who asks for another."""

import numpy as np
import pytest

from flowabs_nodes import graph
from flowabs_nodes.color import detect
from flowabs_nodes.color.spaces import KNOWN, between
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.errors import ArgumentError
from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.write import save
from flowabs_nodes.nodes.colorspace import COLORSPACE
from flowabs_nodes.nodes.declare import Context
from tests.comp.pictures import rgba, run

import OpenImageIO as oiio  # isort: skip


def test_the_matrix_and_back():
    pixels = rgba()
    there = run(COLORSPACE, {"image": Image.from_array(pixels)}, to="ACEScg")
    assert there.colorspace == KNOWN["lin_ap1_scene"]
    expected = pixels[..., :3].astype(np.float64) @ between(KNOWN["lin_rec709"], KNOWN["lin_ap1_scene"]).T
    np.testing.assert_allclose(there.pixels[..., :3], expected, rtol=1e-5, atol=1e-6)
    np.testing.assert_array_equal(there.pixels[..., 3], pixels[..., 3])
    np.testing.assert_allclose(run(COLORSPACE, {"image": there}, to="lin_rec709").pixels, pixels, atol=1e-5)


def test_from_takes_the_numbers_as_another_space():
    image = Image.from_array(rgba())
    result = run(COLORSPACE, {"image": image}, **{"from": "ACEScg", "to": "lin_ap1"})
    assert result.colorspace == KNOWN["lin_ap1_scene"]
    np.testing.assert_array_equal(result.pixels, image.pixels)


def test_neutrals_stay_exactly():
    grey = np.repeat(np.linspace(-1, 5, 50, dtype=np.float32)[None, :, None], 3, axis=2)
    np.testing.assert_array_equal(run(COLORSPACE, {"image": Image.from_array(grey)}, to="ACEScg").pixels, grey)


def test_it_has_neither_mask_nor_mix():
    assert not COLORSPACE.mixes


@pytest.mark.parametrize("parameter", ["from", "to"])
@pytest.mark.parametrize("name", ["sRGB", "ACEScct", "arri_logc3_ei800"])
def test_encodings_are_refused_and_pointed_to_write(parameter, name):
    with pytest.raises(ArgumentError, match=r"is not the name of a scene-linear .* write\.colorspace") as failure:
        call_node(COLORSPACE, Context(), {"image": Image.from_array(rgba())}, {parameter: name})
    assert failure.value.parameter == parameter


def test_check_finds_an_encoding_before_the_first_frame():
    node = {"type": "colorspace@1", "inputs": {"image": "plate"}, "params": {"to": "sRGB"}}
    document = {"format": "flowabs.graph/1", "nodes": {"plate": {"type": "read@1"}, "screen": node}}
    (problem,) = graph.check(document)
    assert (problem.code, problem.pointer) == ("bad-value", "/nodes/screen/params/to")
    assert "write.colorspace" in problem.expected


@pytest.mark.parametrize("value", ["", 5, None, "Raw"])
def test_what_is_no_name_of_a_space_to_convert_to(value):
    assert COLORSPACE.all_params["to"].problem(value)[0] == "bad-value"


def test_a_space_of_another_config_is_looked_up_by_the_run():
    """The graph is good, whatever the pinned config knows; the run says what its own config has not."""
    assert COLORSPACE.all_params["to"].problem("my_studio_linear") is None
    with pytest.raises(ArgumentError, match="has no colour space 'my_studio_linear'") as failure:
        call_node(COLORSPACE, Context(), {"image": Image.from_array(rgba())}, {"to": "my_studio_linear"})
    assert failure.value.parameter == "to"


def test_an_unknown_name_has_the_nearest():
    with pytest.raises(ArgumentError) as failure:
        call_node(COLORSPACE, Context(), {"image": Image.from_array(rgba())}, {"to": "ACEScgg"})
    assert "ACEScg" in failure.value.hint


def test_what_is_written_is_in_the_new_space(tmp_path):
    image = run(COLORSPACE, {"image": Image.from_array(rgba())}, to="ACEScg")
    save(build_picture(image, {}), str(tmp_path / "out.exr"))
    assert detect(oiio.ImageBuf(str(tmp_path / "out.exr")).spec()).space == KNOWN["lin_ap1_scene"]
