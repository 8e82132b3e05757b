"""Begins a session of Blender, runs a small graph in it, and ends it: what the sessions share."""

import hashlib
import json
import os
import sys
from pathlib import Path
from typing import Any

import bpy

GIVEN = json.loads(sys.argv[2])

# Blender itself has OpenImageIO beside NumPy, in a folder that it looks into; its module does not.
_own = Path(bpy.utils.resource_path("LOCAL"), "python", "lib", "python{}.{}".format(*sys.version_info), "site-packages")
sys.path.append(str(_own))


def read_preferences() -> None:
    """Read the preferences, and so enable what is enabled in them: Blender itself does it at its start."""
    bpy.ops.wm.read_userpref()


def tell(**told: Any) -> None:
    """Say what the test asks for, and end."""
    Path(sys.argv[1]).write_text(json.dumps(told, default=str), encoding="utf-8")
    _end(0)


def _end(code: int) -> None:
    """End at once: Blender 4.5 as a module sometimes hangs while Python takes itself apart."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _fail(*error: Any) -> None:
    sys.__excepthook__(*error)
    _end(1)


sys.excepthook = _fail


def is_enabled() -> bool:
    """Return whether the extension is enabled."""
    return "bl_ext.user_default.flowabs_blender" in bpy.context.preferences.addons


def pixels_of(**node: Any) -> str:
    """Run a node of the editor on the picture that is given; return a digest of the pixels that come out."""
    from bl_ext.user_default.flowabs_blender import import_export, tree_json

    import flowabs_nodes

    plate = {"type": "read@1", "params": {"file": GIVEN["picture"]}}
    nodes = {"plate": plate, "made": {**node, "inputs": {"image": "plate"}}}
    tree, _ = import_export.new_tree({"format": "flowabs.graph/1", "name": "small", "nodes": nodes}, "small")
    graph = flowabs_nodes.load_graph(tree_json.graph_of(tree))
    return hashlib.sha256(graph.run(outputs=["made"])["made"].pixels.tobytes()).hexdigest()
