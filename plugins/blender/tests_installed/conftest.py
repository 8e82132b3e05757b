"""Starts Blenders as an artist has them: flowabs is there as the extension's zip, and nowhere else.

``python -m tools.blender`` builds the zip and names it in ``FLOWABS_EXTENSION``; pytest runs in an environment that has
``bpy``, but not flowabs. Each session of Blender is a process of its own, with preferences and extensions in a folder.
"""

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
CHECKOUT = HERE.parents[2]


class Home:
    """A folder with an artist's preferences and extensions, and the sessions of Blender that use it."""

    def __init__(self, folder: Path, zip_file: Path) -> None:
        self.folder = folder
        self.zip = zip_file

    def session(self, name: str, **given: Any) -> Mapping[str, Any]:
        """Run ``sessions/NAME.py`` in a new Blender and return what it tells; what it is given has to be JSON."""
        told = self.folder / "told.json"
        told.unlink(missing_ok=True)
        command = [sys.executable, str(HERE / "sessions" / f"{name}.py"), str(told), json.dumps(given, default=str)]
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        environment["BLENDER_USER_RESOURCES"] = str(self.folder)
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=False)
        assert told.exists(), f"{done.stdout}\n{done.stderr}"
        assert "Traceback" not in done.stderr, done.stderr
        return dict(json.loads(told.read_text(encoding="utf-8")))


@pytest.fixture(scope="session")
def extension_zip() -> Path:
    return Path(os.environ["FLOWABS_EXTENSION"])


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory, extension_zip: Path) -> Home:
    """Return the home of an artist who has never used flowabs."""
    return Home(tmp_path_factory.mktemp("home"), extension_zip)
