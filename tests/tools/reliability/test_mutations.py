"""Damaged files, some dozens; ``python -m tools.reliability.mutations`` reads thousands."""

import sys
from pathlib import Path

import pytest

pytest.importorskip("resource")

from tools.reliability.mutations import WAYS, good_files, mutations, summary
from tools.reliability.reading import Reading, read_all

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits memory as Linux does")


def test_damaged_files_are_refused_or_whole(tmp_path: Path) -> None:
    good = good_files(tmp_path)
    assert {reading.answer for reading in read_all(good)} == {"picture"}
    readings = read_all(mutations(good, tmp_path, 2 * len(good) * len(WAYS), seed=7))
    assert len(readings) == 84
    assert not [f"{reading.path}: {reading.fault}" for reading in readings if reading.fault]
    assert "84 files" in summary(readings)
    assert sum(reading.answer == "refused" for reading in readings) > 40


def test_what_brings_the_child_down_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file of which reading crashes, one that hangs and one that makes a traceback, and the next is read."""
    names = ["crash.exr", "hang.exr", "traceback.exr", "picture.exr"]
    (tmp_path / "sitecustomize.py").write_text(
        """
import os, sys, time
import flowabs_nodes.io.read as read
import tools.reliability.reading as reading
def read_image(name):
    if name == "crash.exr": os.abort()
    if name == "hang.exr": time.sleep(60)
    if name == "traceback.exr": raise ValueError("no family")
read.read_image = read_image
""",
        encoding="utf-8",
    )
    monkeypatch.setattr("tools.reliability.reading.CHECKOUT", f"{tmp_path}:{Path(__file__).parents[3]}")
    readings = read_all(names)
    assert [reading.answer for reading in readings] == ["crash", "hang", "traceback", "picture"]
    assert "no family" in readings[2].fault
    assert "OpenImageIO and OpenEXR" in readings[3].fault


@pytest.mark.parametrize(
    ("reading", "fault"),
    [
        (Reading("a", "picture"), ""),
        (Reading("a", "refused", "damaged"), ""),
        (Reading("a", "picture", others=("OpenEXR",)), "that OpenEXR cannot read whole"),
        (Reading("a", "hang"), "hang"),
    ],
)
def test_what_counts_as_a_fault(reading: Reading, fault: str) -> None:
    assert fault in reading.fault
    assert bool(fault) == bool(reading.fault)
