"""Where the blocks of the documentation run: the package installed from a wheel, and a copy of the checkout."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.docs.blocks import ROOT
from tests.docs.reading import Place

LEFT_BEHIND = (".git", ".venv*", "__pycache__", ".*_cache", "*.egg-info", ".hypothesis", "build", "dist")


@pytest.fixture(scope="session")
def clone(tmp_path_factory) -> Path:
    """Return a copy of the checkout, without what was made in it."""
    folder = tmp_path_factory.mktemp("clone") / "flowabs"
    shutil.copytree(ROOT, folder, ignore=shutil.ignore_patterns(*LEFT_BEHIND))
    return folder


@pytest.fixture(scope="session")
def installed(clone, tmp_path_factory) -> dict[str, str]:
    """Install a wheel into a new environment; return the variables by which a shell finds it, and only it.

    What it depends on comes from the environment that the tests run in, so nothing is downloaded (but for the build
    backend, where this environment lacks it). The checkout is not on the path of this Python.
    """
    folder = tmp_path_factory.mktemp("installed")
    isolation = ["--no-build-isolation"] if find_spec("hatchling") else []
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    run(*pip, "wheel", "--no-deps", *isolation, "--wheel-dir", folder, clone)
    run(sys.executable, "-m", "venv", "--without-pip", folder / "venv")
    python = folder / "venv" / "bin" / "python"
    (wheel,) = folder.glob("*.whl")
    run(*pip, "--python", python, "install", "--no-deps", "--no-index", wheel)
    below = folder / "venv" / Path(sysconfig.get_path("purelib")).relative_to(sys.prefix)
    others = {sysconfig.get_path(each) for each in ("purelib", "platlib")}
    (below / "what_it_depends_on.pth").write_text("\n".join(others), encoding="utf-8")
    cache = os.environ.get("NUMBA_CACHE_DIR") or str(kernels_of_checkout(folder))
    left_out = {"PYTHONPATH", "PYTHONHOME"}
    environment = {name: value for name, value in os.environ.items() if name not in left_out}
    path = os.pathsep.join([str(python.parent), os.environ.get("PATH", os.defpath)])
    return environment | {"PATH": path, "VIRTUAL_ENV": str(python.parents[1]), "NUMBA_CACHE_DIR": cache}


def kernels_of_checkout(folder: Path) -> Path:
    """Return a folder of kernels that leads to those of the checkout, whose sources are the wheel's: compiled once."""
    named = folder / "kernels"
    own = ROOT / "flowabs_nodes" / "__pycache__"
    own.mkdir(exist_ok=True)
    named.mkdir()
    (named / "flowabs").symlink_to(own)
    return named


def run(*command: object) -> None:
    """Run a command; show what it said where it fails."""
    done = subprocess.run([str(each) for each in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode:
        pytest.fail(f"{' '.join(map(str, command))}\n{done.stdout}")


@pytest.fixture
def here(installed, clone, tmp_path) -> Place:
    """Return a folder outside of the checkout, where the package is installed; of a checkout it has docs and graphs."""
    for name in ("docs", "graphs"):
        (tmp_path / name).symlink_to(clone / name)
    return Place(tmp_path, installed)


@pytest.fixture(scope="session")
def in_clone(installed, clone) -> Place:
    """Return the copy of the checkout; Python finds the package there first where it is asked to run a module."""
    return Place(clone, installed)
