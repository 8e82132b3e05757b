"""The example scripts do what they say."""

import runpy
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest
from pictures import held, made, picture, write

import flowabs_nodes as fa
from flowabs_nodes.io.read import read_image

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch):
    """Return the function that runs a script with arguments, as Blender does."""

    def run(name: str, *arguments: str) -> None:
        monkeypatch.setattr(sys, "argv", ["blender", "-b", "--python", name, "--", *arguments])
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")

    return run


def test_picture(example, tmp_path: Path, capfd: pytest.CaptureFixture) -> None:
    plate = write(tmp_path / "plate.exr", picture(30, 40, 3))
    example("picture", plate, str(tmp_path / "lines.exr"))
    values = {"line_width": 1.5, "flat.softness": 0.5}
    expected = fa.load_graph("abstraction").run(given={"plate": read_image(plate)}, set=values, outputs="comp")["comp"]
    np.testing.assert_array_equal(held(bpy.data.images["drawn"])[..., :3], expected.pixels)
    assert (tmp_path / "lines.exr").is_file()
    assert "drawn: 40 x 30, Linear Rec.709" in capfd.readouterr().out


def test_try_knobs(example) -> None:
    made(picture(40, 60), name="plate")
    example("try_knobs", "lines", "line_amount", "0.2", "0.8")
    thin, full = (held(bpy.data.images[f"line_amount {value}"]) for value in ("0.2", "0.8"))
    assert thin.shape == (10, 15, 4)
    assert not np.array_equal(thin, full)


def test_frames(example, tmp_path: Path) -> None:
    for number in (1001, 1002, 1003):
        write(tmp_path / f"shot.{number}.exr", picture(30, 40, 3))
    example("frames", str(tmp_path / "shot.####.exr"), str(tmp_path / "lines.####.exr"), "1001", "1003")
    plate = read_image(tmp_path / "shot.1002.exr")
    expected = fa.load_graph("lines").run(given={"plate": plate}, set={"line_width": 1.25}, outputs="lines")["lines"]
    np.testing.assert_allclose(read_image(tmp_path / "lines.1002.exr").pixels[..., :1], expected.pixels, atol=2e-3)


def test_every_example_is_tested() -> None:
    elsewhere = {"composite"}  # test_compositing_renders.py
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {"picture", "try_knobs", "frames"} | elsewhere
