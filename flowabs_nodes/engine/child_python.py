"""Starts other Python processes that use this very package, and nothing that lies about in the current folder."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import flowabs_nodes

#: Where this package is. It may lie in the current folder, whose other files (a json.py) are nobody's business: so this
#: place comes last, and if another copy comes first the process ends.
_PLACE = Path(flowabs_nodes.__file__).parents[1]
_PROGRAM = """
import sys
sys.path.append(sys.argv[1])
import flowabs_nodes
if flowabs_nodes.__file__ != sys.argv[2]:
    sys.exit(f"flowabs: another copy of the package is found first: {{flowabs_nodes.__file__}}")
from {module} import main
main(*sys.argv[3:])
"""


def can_start() -> bool:
    """Return whether there is a Python to start: not in a program that has one built in."""
    return bool(sys.executable) and not getattr(sys, "frozen", False)


def start(module: str, *arguments: str, **how: Any) -> subprocess.Popen[bytes]:
    """Start a process that calls ``main(*arguments)`` of a module of this package; ``how`` is for Popen.

    Raises OSError where no process can be started.
    """
    there = [path for path in os.environ.get("PYTHONPATH", "").split(os.pathsep) if os.path.isabs(path)]
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _PROGRAM.format(module=module), _PLACE, str(flowabs_nodes.__file__), *arguments],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(there)},
        **how,
    )
