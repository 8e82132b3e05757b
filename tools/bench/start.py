"""Time whole processes, from the command to its end: cold, with no kernel compiled, and warm.

``python -m tools.bench.start [GRAPH]`` prints how long each kernel of a graph takes to compile.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from flowabs_nodes.errors import FlowabsError
from tools.bench.timing import Spread

REPEATS = 7
SIZE = 512


def environment(**more: str) -> dict[str, str]:
    """Return this process's environment, changed so that another Python finds this flowabs too."""
    import flowabs_nodes

    package = str(Path(flowabs_nodes.__file__).resolve().parents[1])
    paths = [package, *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), **more}


def start_times() -> dict[str, Spread]:
    """Return the seconds of each command. The first run is cold and fills the kernel cache; warm runs take turns."""
    from flowabs_nodes.image import Image
    from tools.bench.scene import scene

    with tempfile.TemporaryDirectory(prefix="flowabs-bench-") as folder:
        plate, toon = str(Path(folder) / "plate.exr"), str(Path(folder) / "toon.exr")
        Image.from_array(scene(SIZE, SIZE)).to_imagebuf().write(plate)
        use = environment(NUMBA_CACHE_DIR=str(Path(folder) / "kernels"))
        flowabs = ["-m", "flowabs_nodes"]
        run = [*flowabs, "run", "abstraction", "-i", plate, "-o", toon, "--existing", "overwrite"]
        commands = {
            "python alone": ["-c", "pass"],
            "flowabs --help": [*flowabs, "--help"],
            "flowabs check abstraction": [*flowabs, "check", "abstraction"],
            f"flowabs run abstraction, {SIZE}x{SIZE}": run,
        }
        found = {f"the same, first run ever ({SIZE}x{SIZE})": [_seconds(run, use)]}
        todo = [name for name in commands for _ in range(REPEATS)]
        random.Random(2009).shuffle(todo)
        for name in todo:
            found.setdefault(name, []).append(_seconds(commands[name], use))
    return {name: Spread.of(found[name]) for name in (*commands, *list(found)[:1])}


def compile_times(graph: str) -> dict[str, float]:
    """Return the processor seconds that each kernel of a graph takes to compile, longest first, in a fresh process."""
    with tempfile.TemporaryDirectory(prefix="flowabs-bench-") as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        from numba.core import event

        from flowabs_nodes.cli import main
        from flowabs_nodes.image import Image
        from flowabs_nodes.simd.bands import limited
        from tools.bench.scene import scene

        found: dict[str, float] = {}
        began: list[float] = []  # of a kernel, then of what it is made of

        class Clock(event.Listener):  # type: ignore[misc]
            def on_start(self, event: Any) -> None:
                began.append(time.process_time())

            def on_end(self, event: Any) -> None:
                seconds, function = time.process_time() - began.pop(), event.data["dispatcher"].py_func
                if not began:
                    name = f"{function.__module__}.{function.__qualname__}".removeprefix("flowabs_nodes.")
                    found[name] = found.get(name, 0.0) + seconds

        plate, made = str(Path(folder) / "plate.exr"), str(Path(folder) / "made.exr")
        Image.from_array(scene(SIZE, SIZE)).to_imagebuf().write(plate)
        with event.install_listener("numba:compile", Clock()), limited(1):  # one process compiles all
            code = main(["run", graph, "-i", plate, "-o", made])
        if code != 0:
            raise FlowabsError(f"the graph {graph!r} failed", code="bench-failed")
    return dict(sorted(found.items(), key=lambda item: -item[1]))


def _seconds(arguments: list[str], use: dict[str, str]) -> float:
    begin = time.perf_counter()
    done = subprocess.run([sys.executable, *arguments], env=use, capture_output=True, text=True, check=False)
    taken = time.perf_counter() - begin
    if done.returncode != 0:
        raise FlowabsError(f"{' '.join(arguments)}: {done.stderr.strip()[-2000:]}", code="bench-failed")
    return taken


if __name__ == "__main__":
    times = compile_times(*sys.argv[1:] or ["abstraction"])
    for name, seconds in {**times, "all": sum(times.values())}.items():
        print(f"{seconds:6.2f} s  {name}")
