"""Beside a run: its kernels are made ready before it comes to them, by a thread and, the first time, a second process.

Both run the graph's nodes on a small picture and throw away what comes out. The thread goes from the first node to the
last while the run still reads its plate: modules are imported, and kernels read from disk, in time that was waited.
Where a kernel is not on disk, another process begins as well, from the last node to the first: it leaves what it
compiled on disk, and both meet in the middle (:mod:`flowabs_nodes.simd.kernel_cache`). It ends with the run.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from typing import Any

from flowabs_nodes.engine import child_python
from flowabs_nodes.simd import bands, compile_hooks
from flowabs_nodes.stopping import Stopped

HEIGHT, WIDTH = 24, 40


@contextmanager
def compiling_ahead(graph: str, values: Mapping[str, Any]) -> Iterator[None]:
    """Inside, kernels of a graph are made ready ahead of the run. ``values``: of knobs and parameters."""
    over = threading.Event()
    begun: list[subprocess.Popen[bytes]] = []

    def begin() -> None:
        with suppress(OSError):  # no processes left: then without
            begun.append(_begin(graph, values))

    if bands.thread_count() > 1:
        if child_python.can_start():
            compile_hooks.waiting.append(begin)
        _load_ahead(graph, values, over.is_set)
    try:
        yield
    finally:
        over.set()
        compile_hooks.waiting.clear()
        for process in begun:
            process.kill()
            process.wait()


def _load_ahead(graph: str, values: Mapping[str, Any], over: Callable[[], bool]) -> None:
    """Begin the thread. Its name says that a process may end without waiting for it."""

    def load() -> None:
        with suppress(Exception, Stopped), bands.limited(1):  # the run itself says what is wrong
            run_small(graph, values, own_only=True, over=over)

    threading.Thread(target=load, name="flowabs-ahead", daemon=True).start()


def _begin(graph: str, values: Mapping[str, Any]) -> subprocess.Popen[bytes]:
    """Begin the other process. It ends when its standard input does: with us, however that happens."""
    nowhere = subprocess.DEVNULL
    pipes = {"stdin": subprocess.PIPE, "stdout": nowhere, "stderr": nowhere}
    return child_python.start("flowabs_nodes.cli.precompile", graph, json.dumps(values), **pipes)


def run_small(
    graph: str,
    values: Mapping[str, Any],
    *,
    backwards: bool = False,
    own_only: bool = False,
    over: Callable[[], bool] = lambda: False,
) -> None:
    """Run each node of a graph on small pictures, until ``over`` says so.

    With ``own_only`` nodes of other packages are left out, which may not expect a second thread, and of several nodes
    of a type all but the first.
    """
    from flowabs_nodes.engine.plan import file_role, make_plan, sinks
    from flowabs_nodes.engine.runnable import load_graph
    from flowabs_nodes.errors import FlowabsError

    loaded = load_graph(graph).with_set(values)
    steps = make_plan(loaded, 1, sinks=sinks(loaded))
    seen: set[str] = set()
    for step in reversed(steps) if backwards else steps:
        if over():
            return
        node = loaded.nodes[step.unit.node].declaration
        foreign = not node.run.__module__.startswith("flowabs_nodes.")
        if file_role(loaded, step.unit.node) or (own_only and (foreign or node.type in seen)):
            continue
        seen.add(node.type)
        frames = (0, 1, 2) if node.frames else (1,)  # a node that reads other frames gets one to either side
        given = {}
        for each in step.needs:
            port = loaded.nodes[each.node].declaration.all_outputs[each.output]
            picture = _picture("color" if port.same_as else port.types.split("|")[0])
            given[f"{each.node}.{each.output}"] = dict.fromkeys(frames, picture)
        outputs = [f"{step.unit.node}.{name}" for name in step.wanted]
        with suppress(FlowabsError):  # the run itself says what is wrong
            for image in loaded.run(given=given, outputs=outputs, on_event=lambda event: None).values():
                _ = image.pixels


def _picture(kind: str) -> Any:
    """Return noise of a port type, cut out of a picture of full size: lengths in pixels stay what they are."""
    import numpy as np

    from flowabs_nodes.image import Image
    from flowabs_nodes.port_types import pixel_type

    declared = pixel_type(kind)
    shape = (HEIGHT, WIDTH, len(declared.typical_channels))
    noise = np.random.default_rng(1).random(shape, np.float32).astype(declared.dtype)
    image = Image.from_array(noise, type=kind)
    spec = image.spec
    spec.full_width, spec.full_height = 1920, 1080
    return Image(image.pixels, spec, image.type, colorspace=image.colorspace)


def main(graph: str, values: str) -> None:
    """Compile the kernels of a graph from the last node to the first, unless standard input ends before."""

    def end_with_parent() -> None:
        with suppress(OSError):
            while os.read(0, 1):
                pass
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
    run_small(graph, json.loads(values), backwards=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
