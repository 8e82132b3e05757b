"""A plate whose other parts are damaged is refused, whichever part is read; each part is decoded once."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from flowabs_nodes.errors import ReadError
from flowabs_nodes.io import other_parts
from flowabs_nodes.io.read import read_data, read_image
from flowabs_nodes.io.settings import Settings
from flowabs_nodes.simd.bands import limited
from tests.io.files import colors, parts, planes


@pytest.fixture
def plate(tmp_path: Path) -> Path:
    pixels = colors(80, 60)
    return parts(tmp_path / "plate.exr", *((name, planes(pixels), {}) for name in ("beauty", "diffuse", "specular")))


def test_every_part_must_decode(plate: Path) -> None:
    whole = plate.read_bytes()
    read_image(plate)
    for damaged in (whole[:-10], whole[: -len(whole) // 10], whole[:-300] + bytes(300)):
        plate.write_bytes(damaged)
        for part in ("beauty", "diffuse"):
            with pytest.raises(ReadError, match="in the part 'specular'") as caught:
                read_image(plate, part=part)
            assert (caught.value.code, caught.value.file) == ("damaged", str(plate))
        with pytest.raises(ReadError, match="damaged"):
            read_data(plate, part="specular")
    plate.write_bytes(whole)
    read_image(plate)


def test_a_part_is_decoded_once(plate: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    decoded = []
    plain = other_parts.decodes
    monkeypatch.setattr(
        other_parts, "decodes", lambda source, spec, part: decoded.append(part) or plain(source, spec, part)
    )
    for part in ("diffuse", "beauty", "specular", "diffuse"):
        read_image(plate, part=part)
    assert sorted(decoded) == [0, 2]


@pytest.mark.parametrize("threads", [1, 8])
def test_several_parts_are_decoded_at_a_time(plate: Path, threads: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each waits until as many are being decoded as there may be; which part is damaged is told all the same."""
    together = threading.Barrier(min(threads, 2))
    plain = other_parts.decodes
    monkeypatch.setattr(other_parts, "decodes", lambda *arguments: together.wait(20) >= 0 and plain(*arguments))
    with limited(threads):
        read_image(plate)
        plate.write_bytes(plate.read_bytes()[:-10])
        with pytest.raises(ReadError, match="in the part 'specular'"):
            read_image(plate)


def test_a_part_that_is_too_large_is_not_decoded(plate: Path) -> None:
    with pytest.raises(ReadError, match="is more than") as caught:
        read_image(plate, settings=Settings(max_pixels=100))
    assert caught.value.code == "too-large"


def test_few_files_are_remembered(tmp_path: Path, plate: Path) -> None:
    for number in range(other_parts._FILES + 5):
        copy = tmp_path / f"{number}.exr"
        copy.write_bytes(plate.read_bytes())
        read_image(copy)
    assert len(other_parts._whole) == other_parts._FILES
