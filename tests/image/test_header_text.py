"""Texts of headers that are no UTF-8: old programs wrote Latin-1, and damaged files hold anything."""

from __future__ import annotations

import json
from pathlib import Path

import OpenImageIO as oiio
import pytest

import flowabs_nodes
from flowabs_nodes.image import Image
from flowabs_nodes.image.header_text import with_readable_texts
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.read_id import read_id
from tests.io import renders
from tests.io.files import colors, exr, planes


def plate_with(path: Path, header: dict[str, str], *patches: tuple[bytes, bytes]) -> Path:
    """Write an EXR, and then replace bytes of its header by as many others."""
    exr(path, planes(colors(channels=4)), **header)
    data = path.read_bytes()
    for old, new in patches:
        assert len(old) == len(new)
        assert old in data
        data = data.replace(old, new)
    path.write_bytes(data)
    return path


def test_names_and_values_are_taken_for_latin_1(tmp_path: Path) -> None:
    header = {"artist": "Jos?", "d?part": "ici", "plain": "is kept"}
    plate = plate_with(tmp_path / "plate.exr", header, (b"Jos?", b"Jos\xe9"), (b"d?part", b"d\xe9part"))
    spec = read_image(plate).spec
    found = {each.name: each.value for each in spec.extra_attribs}
    assert (found["artist"], found["départ"], found["plain"]) == ("José", "ici", "is kept")
    assert all(name.encode() for name in found)  # no surrogates
    buffer = Image.from_imagebuf(oiio.ImageBuf(str(plate)))
    assert buffer.spec.getattribute("artist") == "José"


def test_a_readable_header_stays_as_it_is() -> None:
    spec = oiio.ImageSpec()
    spec.attribute("départ", "été")
    spec.attribute("of", oiio.TypeDesc("string[2]"), ("one", "zwölf"))
    spec.attribute("time", oiio.TypeTimeCode, (1, 2))
    assert with_readable_texts(spec).to_xml() == spec.to_xml()


@pytest.mark.parametrize("name", ["out.exr", "out.png", "out.tif"])
def test_such_a_plate_is_written_again(tmp_path: Path, name: str) -> None:
    header = {"artist": "Jos?", "d?part": "ici"}
    plate = plate_with(tmp_path / "plate.exr", header, (b"Jos?", b"Jos\xe9"), (b"d?part", b"d\xe9part"))
    report = flowabs_nodes.run(_COPY, input=str(plate), output=str(tmp_path / name))
    assert report.exit_code == 0
    assert read_image(tmp_path / name).spec.getattribute("artist") == "José"


_COPY = {
    "format": "flowabs.graph/1",
    "nodes": {"plate": {"type": "read@1"}, "out": {"type": "write@1", "inputs": {"image": "plate"}}},
}


def test_a_damaged_name_of_a_colour_space_means_nothing(tmp_path: Path) -> None:
    plate = plate_with(tmp_path / "plate.exr", {"colorInteropID": "lin?rec709"}, (b"lin?rec709", b"lin\xccrec709"))
    assert str(read_image(plate).colorspace) == "lin_rec709"


def test_a_manifest_with_latin_1_names(tmp_path: Path) -> None:
    path = renders.blender45(tmp_path / "ids.exr")
    name = next(iter(json.loads(renders.MANIFEST))).encode()
    path.write_bytes(path.read_bytes().replace(b'"' + name, b'"' + b"\xe2" + name[1:]))
    ids, _ = read_id(path)
    manifest = ids.spec.getattribute("cryptomatte/abc1234/manifest")
    assert manifest == renders.MANIFEST.replace(f'"{name.decode()}', f'"\u00e2{name.decode()[1:]}')
