"""A port type is one declaration: nothing else has a table of types, and a new type needs nothing else."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

import flowabs_nodes
from flowabs_nodes import port_types
from flowabs_nodes.cli.precompile import _picture
from flowabs_nodes.engine.call_node import call_node
from flowabs_nodes.engine.resize import scale_image
from flowabs_nodes.errors import ArgumentError, FlowabsError
from flowabs_nodes.filters.background import FAR
from flowabs_nodes.image import Image, Window
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.write import save
from flowabs_nodes.nodes.declare import Context, Node, Port
from flowabs_nodes.nodes.registry import faults
from flowabs_nodes.port_types import TYPES, PixelType, pixel_type, widest
from flowabs_nodes.testing import check_node
from flowabs_nodes.testing.pictures import SCENES, make_input

UV = PixelType(
    "uv",
    label="UV",
    help="places on a texture",
    channels=(("uv.u", "uv.v"),),
    outside=-1.0,
    stored="exact",
)


@pytest.fixture
def uv(monkeypatch):
    monkeypatch.setitem(port_types._DECLARED, "uv", UV)
    return UV


# ---------------------------------------------------------------------- the declarations


@pytest.mark.parametrize("declared", TYPES.values(), ids=TYPES)
def test_a_declaration_is_consistent(declared):
    assert TYPES[declared.name] is declared
    assert declared.label
    assert declared.help
    assert declared.dtype in (np.float32, np.uint32)
    assert declared.widens_to <= TYPES.keys()
    assert all(len(names) == len(declared.lengths) for names in declared.channels if declared.lengths)
    assert not (declared.filtered and declared.lengths), "what is filtered has no lengths that change with it"
    assert declared.usual[0] < declared.usual[1]
    assert np.asarray(declared.outside, declared.dtype) == declared.outside


def test_the_types_of_the_design():
    found = {name: (declared.channels, str(declared.dtype)) for name, declared in TYPES.items()}
    assert found == {
        "color": ((("R", "G", "B"), ("R", "G", "B", "A")), "float32"),
        "mono": ((("Y",),), "float32"),
        "matte": ((("Y",),), "float32"),
        "flow": ((("flow.x", "flow.y"),), "float32"),
        "depth": ((("Z",),), "float32"),
        "normal": ((("N.X", "N.Y", "N.Z"),), "float32"),
        "motion": ((("motion.X", "motion.Y", "motion.Z", "motion.W"),), "float32"),
        "id": ((("id",),), "uint32"),
        "data": ((), "float32"),
    }
    assert [TYPES[name].bytes_per_pixel for name in ("mono", "flow", "normal", "id", "color", "data")] == [
        *(4, 8, 12, 4, 16, 16)
    ]


def test_only_a_matte_and_a_mono_go_where_others_are_asked_for():
    wider = {(name, other) for name, declared in TYPES.items() for other in declared.widens_to}
    assert wider == {("matte", "mono"), ("matte", "color"), ("mono", "color")}
    assert Port("x", "color|depth", ".").takes("matte") == "color"
    assert Port("x", "mono", ".").takes("depth") is None
    assert Port("x", "any", ".").takes("id") == "id"


def test_an_unknown_type_is_named_with_its_nearest():
    with pytest.raises(ArgumentError, match="did you mean 'depth'"):
        pixel_type("dept")


# ---------------------------------------------------------------------- ids are exact


LARGE = np.array([[0, 2**24 + 1, 2**32 - 1]], np.uint32)


def test_ids_stay_whole_numbers_of_32_bits():
    image = Image.from_array(LARGE, type="id")
    assert image.pixels.dtype == np.uint32
    again = Image.from_imagebuf(image.to_imagebuf())
    assert again.type == "id"
    np.testing.assert_array_equal(again.pixels[..., 0], LARGE)
    np.testing.assert_array_equal(Image.from_array(LARGE.astype(float), type="id").pixels[..., 0], LARGE)
    moved = image.on_window(Window(-1, 0, 4, 1))
    np.testing.assert_array_equal(moved.pixels[0, :, 0], [0, *LARGE[0]])


@pytest.mark.parametrize("pixels", [LARGE * 0.5, LARGE.astype(np.float32), LARGE.astype(np.int64) - 1])
def test_what_was_calculated_with_is_no_id(pixels):
    with pytest.raises(ArgumentError, match="whole numbers from 0 to 4294967295"):
        Image.from_array(LARGE, type="id").with_pixels(pixels)


@pytest.mark.parametrize("pixels", [np.array([[1.5]]), np.array([[np.nan]]), np.array([[2.0**32]]), np.array([[-1]])])
def test_other_numbers_make_no_ids(pixels):
    with pytest.raises(ArgumentError, match="whole numbers"):
        Image.from_array(pixels, type="id")


def test_a_node_that_returns_another_dtype_is_named():
    def run(context, image):
        return image.with_pixels(image.pixels.mean(axis=2))

    node = Node("mean", 1, ".", (Port("image", "id", "."),), (Port("image", "=image", "."),), (), run)
    with pytest.raises(FlowabsError, match=r"node mean: .*id pixels are whole numbers.*float64"):
        call_node(node, Context(), {"image": Image.from_array(LARGE, type="id")}, {})


# ---------------------------------------------------------------------- a new type needs nothing else


def test_a_new_type_is_cut_scaled_and_written(uv, tmp_path):
    image = make_input("uv", "shapes", 20, 24)
    assert image.channels == ("uv.u", "uv.v")
    window = image.data_window
    wider = image.on_window(Window(window.x - 1, window.y, window.width + 1, window.height))
    assert (wider.pixels[:, 0] == -1).all()
    small = scale_image(image, 0.5)
    assert set(small.pixels.ravel()) <= set(image.pixels.ravel())
    color = image.with_pixels(np.ones((20, 24, 3), np.float32), "color")
    save(build_picture(Image(color.pixels, color.spec, "color"), {"place": image}), tmp_path / "a.exr")
    channels = OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True).channels()
    np.testing.assert_array_equal(channels["place.u"].pixels, image.pixels[..., 0])
    assert channels["place.u"].pixels.dtype == np.float32


def test_a_new_type_goes_through_nodes_and_the_compliance_suite(uv):
    def run(context, image):
        return image.with_pixels(image.pixels * np.float32(2))

    node = Node(
        "double", 1, "Doubles.", (Port("image", "uv", "Places."),), (Port("image", "=image", "Twice."),), (), run
    )
    assert faults(node) == []
    check_node(node)
    assert _picture("uv").channels == ("uv.u", "uv.v")


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("kind", TYPES)
def test_the_suite_has_a_picture_of_every_type(kind, scene):
    declared = TYPES[kind]
    pixels = make_input(kind, scene, 20, 24).pixels
    assert pixels.dtype == declared.dtype
    assert np.isfinite(pixels).all()
    assert len(np.unique(pixels)) > 3
    if declared.unit:
        np.testing.assert_allclose(np.linalg.norm(pixels, axis=2), 1, atol=1e-5)
    if kind == "id":
        assert (pixels > 2**24).any()
    if kind == "depth":
        assert 0 < pixels.min() <= pixels.max() < FAR


# ---------------------------------------------------------------------- no other table


#: Words that are also the names of port types: of the arguments of filters and nodes, and of a menu.
OTHER_WORDS = {"choices.py", "filters/warming.py", "nodes/aov_lines.py"}


def tables(tree: ast.AST, names: set[str]) -> list[int]:
    """Return the lines with a dict, a set, or a list that is searched, of two port types or more."""
    lines = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Dict):
            keys = node.keys
        elif isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
            keys = getattr(node.comparators[0], "elts", [])
        elif isinstance(node, ast.Set):
            keys = node.elts
        else:
            continue
        found = {key.value for key in keys if isinstance(key, ast.Constant) and isinstance(key.value, str)}
        if len(found & names) >= 2:
            lines.append(node.lineno)
    return lines


def test_no_other_module_has_a_table_of_port_types():
    package = Path(flowabs_nodes.__file__).parent
    found = [
        f"{path.relative_to(package)}:{line}"
        for path in sorted(package.rglob("*.py"))
        if path.name != "port_types.py" and path.relative_to(package).as_posix() not in OTHER_WORDS
        for line in tables(ast.parse(path.read_text(encoding="utf-8")), set(TYPES))
    ]
    assert not found, f"say it in port_types.py, for each type: {found}"


@pytest.mark.parametrize("code", ['x = {"mono": 1, "flow": 2}', 'x = kind in ("flow", "data")', 'x = {"id", "depth"}'])
def test_a_table_would_be_found(code):
    assert tables(ast.parse(code), set(TYPES)) == [1]


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("matte", "matte"), "matte"),
        (("matte", "mono"), "mono"),
        (("mono", "color", "matte"), "color"),
        (("depth",), "depth"),
        (("depth", "color"), None),
        ((), None),
    ],
)
def test_the_widest_of_some_types(names, found):
    assert widest(names) == found
