"""Small renders of Blender 4.5 and 5.3 (tests/data/blender): each pass and picture is found, by the same names in both.

What is read is compared with the channel that OpenImageIO gives by its whole name.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.read_id import read_id
from flowabs_nodes.io.read_motion import read_motion
from flowabs_nodes.io.read_passes import read_depth, read_normal
from tests.io.files import exr, like, written

DATA = Path(__file__).parents[1] / "data" / "blender"
VERSIONS = ("45", "53")
RENAMED = {"45": {"Diffuse Color": "DiffCol", "Object Index": "IndexOB"}, "53": {}}


def channel(path: Path, name: str, view: str = "") -> np.ndarray:
    """Return the channel of a pass, (H, W): "Fg.Depth" and "Z", of a view where there are two."""
    layer, _, last = name.rpartition(".")
    for index in range(64):
        spec = oiio.ImageBuf(str(path), index, 0).spec()
        if spec.width == 0:
            break
        whole = f"{layer}.{view}.{last}" if spec.getattribute("multiView") else name
        if spec.get_string_attribute("view") in ("", view) and whole in spec.channelnames:
            pixels = oiio.ImageBuf(str(path), index, 0).get_pixels(oiio.FLOAT)
            return pixels[..., spec.channelnames.index(whole)]
    raise AssertionError(name)


def first(image: Image | tuple[Image, Image]) -> Image:
    return image[0] if isinstance(image, tuple) else image


@pytest.mark.parametrize("version", VERSIONS)
def test_the_only_view_layer_goes_before_the_composite_and_is_told(version: str) -> None:
    notes: list[str] = []
    path = DATA / f"comp_{version}.exr"
    image = read_image(path, note=notes.append)
    np.testing.assert_array_equal(image.pixels[..., 0], channel(path, "ViewLayer.Combined.R"))
    assert notes[0].startswith("no plain R, G, B: layer 'ViewLayer.Combined' is read, one of 5 with colour")
    assert "Composite.Combined" in notes[0]
    composite = read_image(path, layer="Composite")
    np.testing.assert_array_equal(composite.pixels[..., 0], channel(path, "Composite.Combined.R"))
    assert not np.array_equal(composite.pixels, image.pixels)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("read", "layer", "name"),
    [
        (read_depth, "", "Depth.Z"),
        (read_normal, "", "Normal.X"),
        (read_motion, "", "Vector.X"),
        (read_id, "Object Index", "Object Index.X"),
        (read_id, "IndexOB", "Object Index.X"),
        (read_id, "object_index", "Object Index.X"),
        (read_image, "albedo", "Diffuse Color.R"),
        (read_image, "DiffCol", "Diffuse Color.R"),
        (read_image, "Diffuse Color", "Diffuse Color.R"),
        (read_image, "ViewLayer.DiffCol", "Diffuse Color.R"),
        (read_image, "ViewLayer.albedo", "Diffuse Color.R"),
        (read_data, "Diffuse Color", "Diffuse Color.R"),
        (read_data, "Normal", "Normal.X"),
    ],
)
def test_a_pass_has_the_same_names_in_both(version: str, read: Any, layer: str, name: str) -> None:
    path = DATA / f"comp_{version}.exr"
    before, _, last = name.rpartition(".")
    whole = f"ViewLayer.{RENAMED[version].get(before, before)}.{last}"
    expected = channel(path, whole)
    assert np.ptp(expected) > 0 or name == "Vector.X"
    np.testing.assert_array_equal(first(read(path, layer=layer)).pixels[..., 0].astype(np.float32), expected)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_cryptomatte_of_objects_with_its_manifest(version: str) -> None:
    for layer in ("", "CryptoObject", "ViewLayer", "cryptomatte", "ViewLayer.Cryptomatte"):
        ids, _ = read_id(DATA / f"comp_{version}.exr", layer=layer)
        assert set(np.unique(ids.pixels)) == {0, 0xD15E1B1E, 0x645D3BC4}
        assert '"crate":"d15e1b1e"' in str(ids.spec.getattribute("cryptomatte/542cafa/manifest"))


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("read", [read_image, read_depth, read_normal, read_motion, read_id])
def test_of_two_view_layers_one_is_named_for_all_nodes(version: str, read: Any) -> None:
    path = DATA / f"stereo_layers_comp_{version}.exr"
    with pytest.raises(ReadError, match=r"'Fg\..*'Bg\.01\.|'Bg\.01\..*'Fg\.") as caught:
        read(path)
    assert caught.value.code == "ambiguous-layer"
    assert "does in every node" in caught.value.hint
    name, plane = {
        read_image: ("Combined.R", 0),
        read_depth: ("Depth.Z", 0),
        read_normal: ("Normal.X", 0),
        read_motion: ("Vector.Z", 2),
        read_id: ("", 0),
    }[read]
    found = {}
    for layer, view in (("Fg", "left"), ("Bg.01", "left"), ("Fg.right", "right"), ("Bg.01.right", "right")):
        notes: list[str] = []
        image = first(read(path, layer=layer, note=notes.append))
        found[layer] = image.pixels
        told = any("view 'left' is read, one of 2: left, right; `layer` says which" in note for note in notes)
        assert told == (view == "left")
        assert image.origin is not None
        assert image.origin.layer.startswith(layer.removesuffix(".right") + ".")
        if name:
            expected = channel(path, f"{layer.removesuffix('.right')}.{name}", view)
            np.testing.assert_array_equal(image.pixels[..., plane], expected)
    assert not np.array_equal(found["Fg"], found["Bg.01"])
    assert not np.array_equal(found["Fg"], found["Fg.right"])
    with pytest.raises(ReadError, match=r"Composite|'Fg\..*right'|'Bg\.01\..*right'"):
        read(path, layer="right")


@pytest.mark.parametrize("version", VERSIONS)
def test_a_pass_of_one_eye(version: str) -> None:
    path = DATA / f"stereo_layers_comp_{version}.exr"
    for layer in ("Fg.Depth.right", "Fg.right"):
        depth = read_depth(path, layer=layer)
        np.testing.assert_array_equal(depth.pixels[..., 0], channel(path, "Fg.Depth.Z", "right"))
    np.testing.assert_array_equal(
        read_image(path, layer="Fg.albedo.right").pixels[..., 2],
        channel(path, f"Fg.{RENAMED[version].get('Diffuse Color', 'Diffuse Color')}.B", "right"),
    )
    for layer in ("Bg.01.CryptoObject.right", "Bg.01.cryptomatte.right"):
        ids, _ = read_id(path, layer=layer)
        name, view = ids.origin.layer, "right"  # type: ignore[union-attr]
        assert name in ("Bg.01.CryptoObject00", f"Bg.01.CryptoObject00.{view}")
        np.testing.assert_array_equal(
            ids.pixels[..., 0].view(np.float32), channel(path, "Bg.01.CryptoObject00.r", view)
        )


@pytest.mark.parametrize("version", VERSIONS)
def test_a_cryptomatte_that_is_not_there(version: str) -> None:
    with pytest.raises(ReadError, match=r"'Bg\.02\.cryptomatte' is not in the file"):
        read_id(DATA / f"stereo_layers_comp_{version}.exr", layer="Bg.02.cryptomatte")
    with pytest.raises(ReadError, match="could be read from several places"):
        read_id(DATA / f"stereo_layers_comp_{version}.exr", layer="cryptomatte")


def test_parts_of_one_eye() -> None:
    path = DATA / "stereo_layers_comp_53.exr"
    for part in ("right", "Fg.Combined-right"):
        image = read_image(path, part=part, layer="Fg")
        np.testing.assert_array_equal(image.pixels[..., 0], channel(path, "Fg.Combined.R", "right"))
    with pytest.raises(ReadError, match=r"part 'right' is not in the file.*layer: 'right'\?"):
        read_image(DATA / "stereo_layers_comp_45.exr", part="right")


@pytest.mark.parametrize("version", VERSIONS)
def test_a_wrong_view_layer_gets_the_nearest(version: str) -> None:
    for read in (read_image, read_depth):
        with pytest.raises(ReadError, match=r"'Bg\.02' is not in the file.*did you mean 'Bg\.01'"):
            read(DATA / f"stereo_layers_comp_{version}.exr", layer="Bg.02")


@pytest.mark.parametrize("version", VERSIONS)
def test_outside_of_a_render_region_nothing_moves_and_all_is_far(version: str) -> None:
    """4.5 writes 1e11 there, 5.3 1e10, and both a motion of 1e4, 1e4."""
    path = DATA / f"border_{version}.exr"
    outside = np.ones((24, 32), bool)
    outside[:12, 8:24] = False
    raw = channel(path, "ViewLayer.Vector.X")
    assert (raw[outside] == 1e4).all()
    motion = read_motion(path)
    assert (motion.pixels[outside] == 0).all()
    np.testing.assert_array_equal(motion.pixels[~outside][:, 2], channel(path, "ViewLayer.Vector.Z")[~outside])
    assert (read_depth(path).pixels[outside] == 1e10).all()
    assert motion.data_window == (0, 0, 32, 24)


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_written_of_one_eye_is_read_again(version: str, tmp_path: Path) -> None:
    path = DATA / f"stereo_layers_comp_{version}.exr"
    image = read_image(path, layer="Fg.right")
    out, _ = written(like(image, image.pixels + 1), tmp_path / "out.exr", keep_layers="*")
    np.testing.assert_allclose(read_image(out).pixels[..., 0], image.pixels[..., 0] + 1, rtol=1e-3)
    for eye in ("left", "right"):
        depth = read_depth(out, layer=f"Fg.Depth.{eye}")
        np.testing.assert_array_equal(depth.pixels[..., 0], channel(path, "Fg.Depth.Z", eye))


def test_a_default_view_without_a_name_beside_another(tmp_path: Path) -> None:
    near, far = np.ones((2, 3), np.float32), np.full((2, 3), 9, np.float32)
    path = exr(tmp_path / "a.exr", {"V.Depth.Z": near, "V.Depth.left.Z": far}, multiView=["right", "left"])
    notes: list[str] = []
    assert read_depth(path, note=notes.append).pixels[0, 0, 0] == 1
    assert "view 'right' is read, one of 2: right, left; `layer` says which" in notes
    assert read_depth(path, layer="V.right").pixels[0, 0, 0] == 1
    for layer in ("left", "V.left", "Depth.left"):
        assert read_depth(path, layer=layer).pixels[0, 0, 0] == 9
