"""Full disks, ten of them; ``python -m tools.reliability.full_disk`` fills hundreds."""

import random
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("resource")

from flowabs_nodes.errors import WriteError
from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.write import save
from tools.reliability.full_disk import KINDS, Frame, Outcome, mounted, shortfalls

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits files as Linux does")


def test_no_frame_is_left_on_a_full_disk(tmp_path: Path) -> None:
    chance = random.Random(5)
    outcomes = []
    for kind in ("zip", "dwaa", "png", "tiff"):
        (tmp_path / kind).mkdir()
        frame = Frame(tmp_path / kind, kind)
        outcomes += [frame.with_a_limit(short) for short in (400, chance.randrange(500, frame.size))]
        try:
            outcomes.append(frame.on_a_small_disk(chance.randrange(1, frame.size)))
        except PermissionError:
            outcomes.append(frame.with_a_limit(frame.size))
    assert not [f"{each.kind}, {each.short}: {each.fault}" for each in outcomes if each.fault]
    assert {each.code for each in outcomes} == {1}


@pytest.mark.parametrize("name", ["out.png", "out.tif"])
def test_a_full_folder_for_temporary_files(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "small").mkdir()
    noise = np.random.default_rng(1).random((100, 100, 3), np.float32)
    picture = build_picture(Image.from_array(noise))
    try:
        with mounted(tmp_path / "small", 8192):
            monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "small"))
            with pytest.raises(WriteError, match="no space is left") as caught:
                save(picture, tmp_path / name)
    except PermissionError as error:
        pytest.skip(str(error))
    assert (caught.value.code, caught.value.file) == ("disk-full", str(tmp_path / name))
    assert not (tmp_path / name).exists()


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({}, ""),
        ({"code": 0, "left": ("frame.png",)}, "silent"),
        ({"code": None}, "hangs"),
        ({"left": (".frame.exr.claim",)}, "left behind: .frame.exr.claim"),
        ({"errors": "damaged or cut short"}, "does not say"),
        ({"code": 2}, "exit code 2"),
    ],
)
def test_what_counts_as_a_fault(changes: dict[str, object], fault: str) -> None:
    good = {"kind": "zip", "short": 8, "code": 1, "errors": "no space is left", "left": ()}
    outcome = Outcome(**(good | changes))  # type: ignore[arg-type]
    assert fault in outcome.fault
    assert bool(fault) == bool(outcome.fault)


def test_shortfalls_begin_with_the_smallest_and_the_largest() -> None:
    assert shortfalls(1000, 3, random.Random(1)) == [1, 1000, 2]
    assert len(KINDS) == 6
