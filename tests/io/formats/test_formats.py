"""The formats as a whole: each is one file of its folder, found by extension and content, and asked for by no name."""

from __future__ import annotations

import ast
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest

import flowabs_nodes
from flowabs_nodes.errors import ReadError, WriteError
from flowabs_nodes.io import formats
from flowabs_nodes.io.formats import Format
from flowabs_nodes.io.formats.exr import EXR
from flowabs_nodes.io.formats.png import PNG
from flowabs_nodes.io.formats.tiff import TIFF
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.write import build_picture, is_whole, save, stored_key
from tests.io.files import colors, exr, flat, planes

PACKAGE = Path(flowabs_nodes.__file__).parent


def test_every_module_of_the_folder_declares_one_format() -> None:
    found = []
    for info in pkgutil.iter_modules(formats.__path__):
        module = importlib.import_module(f"{formats.__name__}.{info.name}")
        declared = [value for value in vars(module).values() if isinstance(value, Format)]
        assert len(declared) == (0 if info.name == "declare" else 1), info.name
        found += declared
    assert set(formats.ALL) == set(found)


def test_extensions_and_first_bytes_belong_to_one_format_each() -> None:
    for values in (
        [extension for format in formats.ALL for extension in format.extensions],
        [magic for format in formats.ALL for magic in format.magic],
        [format.oiio_name for format in formats.ALL],
    ):
        assert len(set(values)) == len(values)


@pytest.mark.parametrize("format", formats.ALL, ids=lambda format: format.name)
def test_a_declaration_is_complete(format: Format) -> None:
    assert format.extensions
    assert format.magic
    assert oiio.ImageInput.create(format.oiio_name) is not None, "OpenImageIO knows no such format"
    assert format.writable == bool(format.data_types)
    if format.writable:
        assert callable(formats.load(format.encoder))


def test_by_extension_and_by_content() -> None:
    assert formats.by_extension("a.b/plate.0001.EXR") is EXR
    assert formats.by_extension("plate.tif") is formats.by_extension("plate.tiff") is TIFF
    assert formats.by_extension("plate") is formats.by_extension("png") is formats.by_extension("a.exr.bak") is None
    assert formats.by_content(b"\x89PNG\r\n") is PNG
    assert formats.by_content(b"MM\x00+....") is TIFF
    assert formats.by_content(b"MM") is formats.by_content(b"") is None


def test_lists_for_people() -> None:
    assert formats.listed((EXR,)) == "EXR"
    assert formats.listed((EXR, PNG, TIFF)) == "EXR, PNG or TIFF"
    assert formats.listed(()) == ""


def test_no_format_is_asked_for_its_name() -> None:
    """Outside the formats' folder no line holds a format's name in OpenImageIO's words: it would be a special case."""
    names = {format.oiio_name for format in formats.ALL}
    special = [
        f"{path.relative_to(PACKAGE)}:{node.lineno}"
        for path in PACKAGE.rglob("*.py")
        if path.parent != PACKAGE / "io" / "formats"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in names
    ]
    assert not special


def test_the_formats_are_known_without_openimageio() -> None:
    """Help texts list them: no reader or writer is imported for that."""
    code = (
        "import sys; from flowabs_nodes.io import formats; assert formats.ALL; assert 'OpenImageIO' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_a_new_format_is_one_declaration(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Targa is no format of ours. Declared, it is read, written, checked, and carries its key."""
    image = read_image(
        flat(tmp_path / "plate.png", (np.random.default_rng(0).random((8, 9, 3)) * 255).astype(np.uint8))
    )
    with pytest.raises(WriteError, match="not a picture format"):
        save(build_picture(image), tmp_path / "a.tga")
    targa = Format(
        name="Targa",
        oiio_name="targa",
        extensions=(".tga",),
        magic=(b"\x00\x00\x02", b"\x00\x00\x0a"),
        display_referred=True,
        encoder="flowabs_nodes.io.encode_flat:encode_flat",
        data_types=("uint8",),
        stamps="description",
    )
    monkeypatch.setattr(formats, "ALL", (*formats.ALL, targa))
    save(build_picture(image), tmp_path / "a.tga", key="the key")
    assert stored_key(tmp_path / "a.tga") == "the key"
    assert is_whole(tmp_path / "a.tga")
    np.testing.assert_array_equal(read_image(tmp_path / "a.tga").pixels, image.pixels)
    (tmp_path / "b.tga").write_bytes((tmp_path / "plate.png").read_bytes())
    with pytest.raises(ReadError, match="not a Targa file: it is a PNG file"):
        read_image(tmp_path / "b.tga")


def test_capitals_are_the_same_format(tmp_path: Path) -> None:
    path = exr(tmp_path / "PLATE.EXR", planes(colors()))
    np.testing.assert_array_equal(read_image(path).pixels, colors().astype(np.float32))
