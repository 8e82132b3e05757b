"""The zip is one that Blender takes, of the size and permissions that an artist is asked to allow."""

import subprocess
import sys
import tomllib
from pathlib import Path
from zipfile import ZipFile

import bpy

PLUGIN = Path(__file__).parents[1]


def test_blender_takes_it(extension_zip: Path) -> None:
    command = [sys.executable, str(PLUGIN / "validate.py"), str(extension_zip)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_it_asks_for_files_only(extension_zip: Path) -> None:
    with ZipFile(extension_zip) as file:
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
    assert list(manifest["permissions"]) == ["files"]


def test_it_is_for_this_blender(extension_zip: Path) -> None:
    with ZipFile(extension_zip) as file:
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
    assert tuple(map(int, manifest["blender_version_min"].split("."))) <= bpy.app.version
