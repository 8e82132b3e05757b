"""Find the Python that a Blender's ``bpy`` module needs: one of another minor version cannot load it."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

from flowabs_nodes.errors import CommandError


def find(version: str) -> Path:
    """Return an interpreter of a version such as "3.13": on the PATH, or else among those of pyenv.

    Raises CommandError where there is none. One that is found is started, as names on the PATH may be stand-ins for
    versions that are not chosen.
    """
    for candidate in _candidates(version):
        if is_version(candidate, version):
            return candidate
    raise CommandError(
        f"no Python {version} is installed here",
        code="no-interpreter",
        hint=f"install it, or name one: --python {version}=/path/to/python",
    )


def _candidates(version: str) -> Iterator[Path]:
    on_path = shutil.which(f"python{version}")
    if on_path is not None:
        yield Path(on_path)
    root = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv")
    yield from sorted(root.glob(f"versions/{version}.*/bin/python"), reverse=True)


def is_version(python: Path, version: str) -> bool:
    """Return whether an interpreter starts and is of that version."""
    show = "import sys; print('%d.%d' % sys.version_info[:2])"
    try:
        said = subprocess.run([python, "-c", show], capture_output=True, text=True, timeout=60, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return said.returncode == 0 and said.stdout.strip() == version
