"""The ready-made numbers are colour-science's."""

import subprocess
import sys

from flowabs_nodes.color import constants
from tools.colour_science import differences


def test_every_number_is_colour_sciences():
    assert differences() == []


def test_a_difference_is_told(monkeypatch):
    wrong = (*constants.BRADFORD[:8], 1.0297)
    monkeypatch.setattr(constants, "BRADFORD", wrong)
    (told,) = differences()
    assert told.startswith("BRADFORD")
    assert "1.0297" in told


def test_importing_color_is_light():
    heavy = ("numba", "colour", "OpenImageIO")
    code = (
        "import sys; from flowabs_nodes import color; color.space('ACEScg'); color.lstar([0.18])\n"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_public_name_is_there():
    from flowabs_nodes import color

    assert set(color.__all__) == {name for name in color.__all__ if getattr(color, name) is not None}
    assert callable(color.encode)
    assert callable(color.encode)  # also after its module was imported
