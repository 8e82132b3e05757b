"""Makes sequences of small EXR plates on disk and graphs over them, runs these, and reads what came of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

from flowabs_nodes import engine
from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.report import Report
from flowabs_nodes.graph.model import Graph
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Param, Port


def plate(path: Path, *, seed: int = 1, height: int = 48, width: int = 64, depth: str = "half") -> Path:
    """Write a scene-linear EXR: smooth shapes and a little noise."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:height, :width]
    rgb = np.stack([x / width, y / height, np.hypot(x - 30, y - 20) < 12], axis=2) * 0.5
    buf = Image.from_array(rgb + rng.random((height, width, 1)) * 0.05).to_imagebuf()
    path.parent.mkdir(parents=True, exist_ok=True)
    assert buf.write(str(path), depth), buf.geterror()
    return path


def plates(folder: Path, *frames: int) -> str:
    """Write a plate a frame, each different, and return their pattern."""
    for frame in frames:
        plate(folder / f"plate.{frame:04d}.exr", seed=frame)
    return str(folder / "plate.####.exr")


def document(**nodes: dict[str, Any]) -> dict[str, Any]:
    """Return a graph file: plate -> bright -> out, and ``nodes`` beside or instead of these."""
    known: dict[str, Any] = {
        "plate": {"type": "read@1"},
        "bright": {"type": "exposure@1", "inputs": {"image": "plate"}, "params": {"stops": {"from": "stops"}}},
        "out": {"type": "write@1", "inputs": {"image": "bright"}},
    }
    knobs = {"stops": {"type": "float", "default": 1.0, "min": -5, "max": 5, "help": "Stops."}}
    return {"format": "flowabs.graph/1", "name": "bright", "interface": knobs, "nodes": known | nodes}


def graph_around(run: Callable[..., Any], *params: Param) -> Graph:
    """Return the graph with another node in place of ``bright``, which does what ``run(context, image, ...)`` says."""
    port = Port("image", "color", "A picture.")
    node = Node("trouble", 1, "A test's own.", (port,), (Port("image", "=image", "The result."),), params, run)
    changed = document(bright={"type": "trouble@1", "inputs": {"image": "plate"}})
    return graphs.load(changed, catalogue() | {"trouble": node})


def raising(error: BaseException, on: int = 2) -> Graph:
    """Return the graph with a node that raises ``error`` on one frame."""

    def run(context: Context, image: Image) -> Image:
        if context.frame == on:
            raise error
        return image

    return graph_around(run)


def pixels(path: Path | str) -> np.ndarray[Any, Any]:
    """Read the pixels of a file."""
    buf = oiio.ImageBuf(str(path))
    assert buf.read(convert=oiio.FLOAT), buf.geterror()
    found: np.ndarray[Any, Any] = buf.get_pixels(oiio.FLOAT)
    return found


def run(shot: str | Path | None, out: Any, graph: Any = None, **options: Any) -> Report:
    """Run a graph, by default :func:`document`, from ``shot`` to ``out``."""
    return engine.run(graph or document(), input=shot, output=out, **options)


def statuses(report: Report) -> list[tuple[int, str]]:
    """Return each frame's number and status."""
    return [(frame.frame, frame.status) for frame in report.frames]


def codes(report: Report) -> dict[int, str]:
    """Return the error's code of each frame that failed."""
    return {frame.frame: frame.error.code for frame in report.frames if frame.error}


def leftovers(folder: Path) -> list[Path]:
    """Return the temporary files and claims anywhere in a folder."""
    return [path for path in folder.rglob(".*") if path.is_file()]
