"""The first run ever: two processes compile kernels, this one those of the graph's first nodes, another the last ones'.

The other one runs every node on a small picture, from the last to the first, only to leave compiled kernels on disk,
where this process finds them in its turn (:mod:`flowabs_nodes.simd.kernel_cache`). It is ended with the run.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, cast

from flowabs_nodes.simd import bands, compile_hooks

HEIGHT, WIDTH = 24, 40


@contextmanager
def compiling_ahead(graph: str, values: Mapping[str, Any]) -> Iterator[None]:
    """Inside, should a kernel have to be compiled, the other process begins. ``values``: of knobs and parameters."""
    begun: list[subprocess.Popen[str]] = []

    def begin() -> None:
        with suppress(OSError):  # no processes left: then without
            begun.append(_begin(graph, values))

    if bands.thread_count() > 1 and not getattr(sys, "frozen", False):  # there is a Python to start
        compile_hooks.waiting.append(begin)
    try:
        yield
    finally:
        compile_hooks.waiting.clear()
        for process in begun:
            process.kill()
            process.wait()


def _begin(graph: str, values: Mapping[str, Any]) -> subprocess.Popen[str]:
    path = os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])
    return subprocess.Popen(
        [sys.executable, "-m", "flowabs_nodes.cli.precompile", graph, json.dumps(values)],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
    )


def compile_backwards(graph: str, values: Mapping[str, Any]) -> None:
    """Run each node of a graph on small pictures, the last one first."""
    from flowabs_nodes.engine.plan import file_role, make_plan, sinks
    from flowabs_nodes.engine.runnable import load_graph
    from flowabs_nodes.errors import FlowabsError

    loaded = load_graph(graph).with_set(values)
    for step in reversed(make_plan(loaded, 1, sinks=sinks(loaded))):
        if file_role(loaded, step.unit.node):
            continue
        given = {}
        for each in step.inputs.values():
            port = loaded.nodes[each.node].declaration.all_outputs[each.output]
            given[f"{each.node}.{each.output}"] = _picture("color" if port.same_as else port.types.split("|")[0])
        outputs = [f"{step.unit.node}.{name}" for name in step.wanted]
        with suppress(FlowabsError):  # the run itself says what is wrong
            for image in loaded.run(given=given, outputs=outputs).values():
                _ = image.pixels


def _picture(kind: str) -> Any:
    """Noise of a port type, cut out of a picture of full size: lengths in pixels stay what they are."""
    import numpy as np

    from flowabs_nodes.image import Image, PortType

    channels = {"color": 3, "flow": 2, "data": 2}.get(kind, 1)
    noise = np.random.default_rng(1).random((HEIGHT, WIDTH, channels), np.float32)
    image = Image.from_array(noise, type=cast(PortType, kind))
    spec = image.spec
    spec.full_width, spec.full_height = 1920, 1080
    return Image(image.pixels, spec, image.type, colorspace=image.colorspace)


if __name__ == "__main__":
    compile_backwards(sys.argv[1], json.loads(sys.argv[2]))
