"""The extension is installed, used, used again, and removed, in one session of Blender after the other."""

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from conftest import CHECKOUT, Home

PICTURE = CHECKOUT / "docs" / "pictures" / "coffee.exr"


@pytest.fixture(scope="module")
def installed(home: Home) -> Mapping[str, Any]:
    """Return what the session told in which the extension was installed."""
    return home.session("install", zip=home.zip, picture=PICTURE)


@pytest.fixture(scope="module")
def duotone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the example package, installed as the docs say."""
    folder = tmp_path_factory.mktemp("packages")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(folder)]
    subprocess.run([*pip, str(CHECKOUT / "plugins" / "example_node")], check=True, timeout=120)
    return folder


def test_it_is_enabled_and_runs(installed: Mapping[str, Any]) -> None:
    assert installed["enabled"]
    assert installed["pixels"]


def test_the_next_session_has_it(home: Home, installed: Mapping[str, Any]) -> None:
    told = home.session("use", picture=PICTURE)
    assert told["enabled"]
    assert told["pixels"] == installed["pixels"]
    for name in ("flowabs_nodes", "numba", "OpenImageIO"):
        assert told["packages"][name].startswith(str(home.folder / "extensions")), name
    assert not told["packages"]["numpy"].startswith(str(home.folder)), "Blender's own NumPy has to stay"


def test_nodes_of_another_package_are_there_too(home: Home, installed: Mapping[str, Any], duotone: Path) -> None:
    told = home.session("other_package", packages=duotone, picture=PICTURE)
    assert "duotone" in told["tones"]
    assert told["pixels"] != installed["pixels"]


def test_it_goes_without_a_trace(home: Home, installed: Mapping[str, Any]) -> None:
    assert list(home.folder.rglob("flowabs_*"))
    assert home.session("remove") == {"was_enabled": True, "enabled": False}
    left = [path for path in home.folder.rglob("*") if path.is_file() and path.suffix != ".blend"]
    assert [path for path in left if "flowabs" in str(path) or "numba" in str(path)] == []
