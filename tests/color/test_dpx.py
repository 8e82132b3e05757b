"""The encoding that a DPX says itself."""

import OpenImageIO as oiio
import pytest

from flowabs_nodes.color import dpx
from flowabs_nodes.color.named import find


def header(data_type="uint16", **attributes):
    spec = oiio.ImageSpec(4, 3, 3, data_type)
    for name, value in attributes.items():
        spec.attribute(name.replace("__", ":"), value)
    return spec


@pytest.mark.parametrize(
    ("transfer", "bits", "expected"),
    [
        ("Printing density", 10, "cineon"),
        ("Linear", 16, "lin_rec709"),
        ("ITU-R 709-4", 10, "srgb_rec709_scene"),
        ("ADX", 10, "ADX10"),
        ("ADX", 16, "ADX16"),
        ("Undefined", 8, "srgb_rec709_scene"),
        ("Undefined", 10, "cineon"),
        ("Undefined", 32, "lin_rec709"),
    ],
)
def test_the_transfer_characteristic_counts_and_without_one_the_bits(transfer, bits, expected):
    spec = header(dpx__Transfer=transfer, oiio__BitsPerSample=bits)
    name, how = dpx.declared(spec)
    assert name == expected
    assert (transfer in how) is (transfer != "Undefined")
    assert find(name).name, "a name that the pinned config knows"


def test_a_header_without_the_field_is_no_dpx():
    assert dpx.declares(header(dpx__Transfer="Undefined"))
    assert not dpx.declares(header())
