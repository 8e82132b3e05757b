"""Starts the Blender of this machine with a window, on a display of its own, and has a script use it.

``python -m tools.blender`` names that Blender in ``FLOWABS_BLENDER``. pytest runs in an environment of the same Python
that has flowabs; the packages of that environment are Blender's too.
"""

import json
import os
import subprocess
import sysconfig
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
CHECKOUT = HERE.parents[2]
SIZE = ("1280", "720")

Told = Mapping[str, Any]


@pytest.fixture
def blender(tmp_path: Path) -> Callable[..., str]:
    """Return the function that runs a script in a Blender with a window until it closes, and returns what was said."""

    def run(script: Path, *arguments: str) -> str:
        display = ("xvfb-run", "-a", "-s", f"-screen 0 {SIZE[0]}x{SIZE[1]}x24 +extension GLX")
        window = ("--factory-startup", "--enable-event-simulate", "--window-geometry", "0", "0", *SIZE)
        program = (os.environ["FLOWABS_BLENDER"], "--python-use-system-env", *window)
        paths = [str(HERE), str(HERE.parent), str(CHECKOUT), sysconfig.get_path("purelib")]
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join(paths),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "BLENDER_USER_RESOURCES": str(tmp_path),
        }
        command = [*display, *program, "--python", str(script), "--", *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=180, check=False)
        said = done.stdout + done.stderr
        assert "Traceback" not in said, said
        assert "Error" not in said, said
        return said

    return run


@pytest.fixture
def window(blender: Callable[..., str], tmp_path: Path) -> Callable[..., Told]:
    """Return the function that runs ``windows/NAME.py`` in a window, and returns what it tells."""

    def run(name: str, **given: Any) -> Told:
        told = tmp_path / "told.json"
        said = blender(HERE / "windows" / f"{name}.py", str(told), json.dumps(given, default=str))
        assert told.exists(), said
        return dict(json.loads(told.read_text(encoding="utf-8")))

    return run
