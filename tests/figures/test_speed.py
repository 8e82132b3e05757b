"""Fig. 23: the benchmark runs and what it writes is whole. How fast it is, is never a test."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ElementTree

import pytest

from tools.gallery import speed


def test_the_command_writes_numbers_and_a_plot(tmp_path, capsys):
    numbers, picture = tmp_path / "fig23.json", tmp_path / "fig23.svg"
    given = ["--size", "32", "--radii", "2", "3", "5", "--repeats", "2"]
    speed.main([*given, "--json", str(numbers), "--svg", str(picture)])
    found = json.loads(numbers.read_text(encoding="utf-8"))
    assert found["picture"] == "32x32 RGB"
    assert found["radii"] == [2, 3, 5]
    assert {name.split()[0].strip(",") for name in found["filters"]} == {"ETF", "FDoG", "FBL", "bilateral"}
    for run in found["filters"].values():
        assert len(run["min"]) == len(run["median"]) == 3
        assert all(0 <= least <= middle for least, middle in zip(run["min"], run["median"], strict=True))
        assert all(math.isfinite(value) for value in run["line"].values())
    drawn = ElementTree.parse(picture).getroot()
    assert drawn.tag.endswith("svg")
    words = " ".join(element.text or "" for element in drawn.iter() if element.tag.endswith("text"))
    assert all(name in words for name in found["filters"])
    assert len(capsys.readouterr().out.splitlines()) == len(found["filters"])


def test_the_fit_is_least_squares():
    line = speed.fit([1, 2, 3, 4], [3.0, 5.0, 7.0, 9.0])
    assert line == pytest.approx((1.0, 2.0, 1.0))
    assert speed.fit([1, 2, 3], [2.0, 2.0, 2.0]).r2 == 1
    assert speed.fit([1, 2, 3, 4], [1.0, -1.0, 1.0, -1.0]).r2 == pytest.approx(0.2)
