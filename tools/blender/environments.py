"""Make an environment with a Blender's ``bpy``, this checkout and pytest, and keep it in a folder for the next time."""

from __future__ import annotations

import hashlib
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from flowabs_nodes.errors import FlowabsError

CHECKOUT = Path(__file__).parents[2]
STAMP = "flowabs-environment.txt"


@dataclass(frozen=True)
class Blender:
    """Names a version of Blender that is tested, and the Python that its module is built for."""

    version: str
    python: str

    @property
    def requirements(self) -> tuple[str, ...]:
        """Return what pip installs, in one call: a second one would exchange Blender's own NumPy."""
        return (f"bpy=={self.version}.*", "--editable", str(CHECKOUT), "pytest>=8")


BLENDERS: Mapping[str, Blender] = {
    each.version: each for each in (Blender("4.5", python="3.11"), Blender("5.2", python="3.13"))
}


def make(blender: Blender, python: Path, cache: Path) -> Path:
    """Return the interpreter of an environment in ``cache``, made or brought up to date if need be.

    Takes about a minute and 1.5 GB for a new one. Raises FlowabsError, with what pip said, where it fails.
    """
    folder = cache / f"blender-{blender.version}"
    own = folder / "bin" / "python"
    stamp = folder / STAMP
    wanted = _stamp(blender)
    if own.exists() and stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted:
        return own
    stamp.unlink(missing_ok=True)  # nothing that is half made counts
    _call("cannot make an environment", [str(python), "-m", "venv", "--clear", str(folder)])
    pip = [str(own), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    _call(f"cannot install Blender {blender.version}", [*pip, *blender.requirements])
    stamp.write_text(wanted, encoding="utf-8")
    return own


def _stamp(blender: Blender) -> str:
    """Return what an environment depends on: what is installed, of which checkout, and its dependencies."""
    dependencies = hashlib.sha256((CHECKOUT / "pyproject.toml").read_bytes()).hexdigest()
    return "\n".join([*blender.requirements, dependencies])


def _call(failure: str, command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = "\n".join((done.stderr or done.stdout).strip().splitlines()[-15:])
        raise FlowabsError(
            f"{failure}: {' '.join(command)} ended with {done.returncode}\n{last}", code="no-environment"
        )
