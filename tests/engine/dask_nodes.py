"""A node that takes its time, or ends the worker of Dask that it runs on: where workers of Dask can import it."""

from __future__ import annotations

import os
import signal
import time
from typing import Any

from flowabs_nodes import graph as graphs
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Param, Port
from tests.engine.sequences import document


def _run(context: Context, image: Image, *, seconds: float, deadly: int) -> Image:
    if context.frame == deadly:
        os.kill(os.getppid(), signal.SIGKILL)
        time.sleep(2)  # until this process knows that its worker is gone
    time.sleep(seconds)
    return image


TROUBLE = Node(
    type="trouble",
    version=1,
    help="A test's own.",
    inputs=(Port("image", "color", "A picture."),),
    outputs=(Port("image", "=image", "The same."),),
    params=(
        Param.float("seconds", 0.0, min=0, max=1000, help="How long it takes."),
        Param.int("deadly", 0, min=0, max=1000, help="The frame whose worker is killed."),
    ),
    run=_run,
)


def trouble(**params: Any) -> Graph:
    """Return plate -> bright -> trouble -> out."""
    nodes = {
        "trouble": {"type": "trouble@1", "inputs": {"image": "bright"}, "params": params},
        "out": {"type": "write@1", "inputs": {"image": "trouble"}},
    }
    return graphs.load(document(**nodes), catalogue() | {"trouble": TROUBLE})
