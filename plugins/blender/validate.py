"""Have Blender's own check read an extension's zip; a Python that has ``bpy`` runs it: ``python validate.py ZIP``."""

import os
import sys

import bpy  # noqa: F401 - finds Blender's own modules
from bl_pkg.bl_extension_cli import cli_extension_handler

code = cli_extension_handler(["validate", sys.argv[1]])  # as blender --command extension validate ZIP
sys.stdout.flush()
os._exit(code)  # Blender 4.5 as a module sometimes hangs while Python takes itself apart
