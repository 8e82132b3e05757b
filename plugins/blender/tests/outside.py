"""Runs a function of a test in a Blender of its own, with a time limit: a render that hangs or crashes is one test's.

``python outside.py FILE FUNCTION ARGUMENTS`` is that process: the extension is registered, and is not unregistered.
"""

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

SECONDS = 120


def outside(function: Callable[..., Any], *arguments: Any) -> Any:
    """Return what a function of a test's file returns in another process, as JSON has it."""
    done = run(function, *arguments)
    assert done.returncode == 0, f"{done.stdout[-3000:]}\n{done.stderr[-6000:]}"
    return json.loads(done.stdout.rsplit("RESULT ", 1)[1])


def run(function: Callable[..., Any], *arguments: Any) -> subprocess.CompletedProcess[str]:
    """Return how the process ended that called the function, and what it printed. Raises TimeoutExpired."""
    file, name = function.__code__.co_filename, function.__name__
    command = [sys.executable, __file__, file, name, json.dumps([str(each) for each in arguments])]
    return subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)


if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))
    import flowabs_blender

    flowabs_blender.register()
    spec = importlib.util.spec_from_file_location("under_test", sys.argv[1])
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    print("RESULT", json.dumps(getattr(module, sys.argv[2])(*json.loads(sys.argv[3]))))
