"""Make environments with a Blender's ``bpy``, this checkout and pytest, and keep them in a folder for the next time."""

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
class Environment:
    """Names an environment, its Python, and what pip installs in one call: a second would exchange Blender's NumPy."""

    name: str
    python: str
    requirements: tuple[str, ...]


@dataclass(frozen=True)
class Blender:
    """Names a version of Blender that is tested, the Python that its module is built for, and its own NumPy."""

    version: str
    python: str
    numpy: str

    @property
    def with_flowabs(self) -> Environment:
        """Return the environment in which the checkout itself is tested."""
        requirements = (f"bpy=={self.version}.*", "--editable", str(CHECKOUT), "pytest>=8")
        return Environment(f"blender-{self.version}", self.python, requirements)

    @property
    def clean(self) -> Environment:
        """Return the environment that has what an artist's Blender has, and pytest: flowabs comes as an extension."""
        requirements = (f"bpy=={self.version}.*", f"numpy=={self.numpy}.*", "pytest>=8")
        return Environment(f"clean-{self.version}", self.python, requirements)


BLENDERS: Mapping[str, Blender] = {
    each.version: each
    for each in (
        Blender("4.5", python="3.11", numpy="1.26"),
        Blender("5.2", python="3.13", numpy="2.3"),
    )
}


def make(environment: Environment, python: Path, cache: Path) -> Path:
    """Return the interpreter of an environment in ``cache``, made or brought up to date if need be.

    Takes about a minute and 1.5 GB for a new one. Raises FlowabsError, with what pip said, where it fails.
    """
    folder = cache / environment.name
    own = folder / "bin" / "python"
    stamp = folder / STAMP
    wanted = _stamp(environment)
    if own.exists() and stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted:
        return own
    stamp.unlink(missing_ok=True)  # nothing that is half made counts
    call("cannot make an environment", [str(python), "-m", "venv", "--clear", str(folder)])
    pip = [str(own), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    call(f"cannot install {environment.name}", [*pip, *environment.requirements])
    stamp.write_text(wanted, encoding="utf-8")
    return own


def _stamp(environment: Environment) -> str:
    """Return what an environment depends on: what is installed, of which checkout, and its dependencies."""
    dependencies = hashlib.sha256((CHECKOUT / "pyproject.toml").read_bytes()).hexdigest()
    return "\n".join([*environment.requirements, dependencies])


def call(failure: str, command: list[str]) -> None:
    """Run a command; raise FlowabsError, with its last lines, where it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        last = "\n".join((done.stderr or done.stdout).strip().splitlines()[-15:])
        raise FlowabsError(
            f"{failure}: {' '.join(command)} ended with {done.returncode}\n{last}", code="no-environment"
        )
