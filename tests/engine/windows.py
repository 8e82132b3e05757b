"""Makes nodes that read other frames, small sequences for them, and graphs that count what runs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from flowabs_nodes import graph as graphs
from flowabs_nodes.engine.runnable import RunnableGraph, load_graph
from flowabs_nodes.image import Image
from flowabs_nodes.nodes import catalogue
from flowabs_nodes.nodes.declare import Context, Node, Param, Port


def mean_frames(params: Mapping[str, Any]) -> dict[str, tuple[int, ...]]:
    return {"image": tuple(range(-params["radius"], params["radius"] + 1))}


def run_mean(context: Context, image: Mapping[int, Image], *, radius: int) -> Image:
    total = np.sum([each.pixels.astype(np.float64) for each in image.values()], axis=0)
    return image[0].with_pixels((total / len(image)).astype(np.float32))


MEAN = Node(
    type="mean",
    version=1,
    help="The mean over a window of frames.",
    inputs=(Port("image", "color|mono|matte", "A picture."),),
    outputs=(Port("image", "=image", "The mean."),),
    params=(Param.int("radius", 2, min=0, max=64, soft=(0, 4), help="How many frames before and after are read."),),
    run=run_mean,
    frames=mean_frames,
)


def asking(frames: Any, run: Callable[..., Any] = run_mean) -> Node:
    """Return the mean of the frames that ``frames`` asks for, a function or what it returns."""
    asked = frames if callable(frames) else lambda params: frames
    return replace(MEAN, run=run, frames=asked)


def counting(calls: Counter[tuple[str, int]]) -> Node:
    """Return a node that gives its picture times ``gain`` and counts its calls by node and frame."""

    def run(context: Context, image: Image, *, gain: float) -> Image:
        calls[context.node, context.frame] += 1
        context.note(f"seen {context.frame}")
        return image.with_pixels(image.pixels * np.float32(gain))

    port = Port("image", "color", "A picture.")
    gain = Param.float("gain", 1.0, min=-100, max=100, help="How much.")
    return Node("count", 1, "Counts.", (port,), (Port("image", "=image", "The picture."),), (gain,), run)


def load(nodes: Mapping[str, Any], *declarations: Node) -> RunnableGraph:
    """Load a graph of ``nodes``, which may be of ``declarations`` too."""
    known = catalogue() | {each.type: each for each in declarations}
    return load_graph(graphs.load({"format": "flowabs.graph/1", "name": "windows", "nodes": dict(nodes)}, known))


def node(type: str, image: str = "", inputs: Mapping[str, str] | None = None, **params: Any) -> dict[str, Any]:
    """Return a node of a graph file."""
    links = ({"image": image} if image else {}) | dict(inputs or {})
    return {"type": f"{type}@1", "inputs": links, "params": params}


def chain(*names: str, **params: Mapping[str, Any]) -> dict[str, Any]:
    """Return the nodes plate -> ``names`` -> out, each of the type before the underscore: "mean_2" is a mean."""
    order = ("plate", *names)
    nodes = {"plate": node("read", **params.get("plate", {}))}
    for before, name in zip(order, names, strict=False):
        nodes[name] = node(name.split("_")[0], before, **params.get(name, {}))
    return nodes | {"out": node("write", order[-1], data_type="float")}


def grey(value: float, height: int = 4, width: int = 6) -> Image:
    """Return a picture of one grey."""
    return Image.from_array(np.full((height, width, 3), value))


def greys(folder: Path, *frames: int, name: str = "plate") -> str:
    """Write a plate a frame, of 2 to the power of the frame's number, and return their pattern."""
    for frame in frames:
        grey_plate(folder / f"{name}.{frame:04d}.exr", 2.0**frame)
    return str(folder / f"{name}.####.exr")


def grey_plate(path: Path, value: float) -> Path:
    """Write a plate of one grey, as float."""
    path.parent.mkdir(parents=True, exist_ok=True)
    buf = grey(value).to_imagebuf()
    assert buf.write(str(path), "float"), buf.geterror()
    return path


def frames_in(value: float, count: int) -> list[int]:
    """Return the frames whose plates (:func:`greys`) a mean of ``count`` frames was taken of."""
    total = round(value * count)
    assert abs(total - value * count) < 1e-3 * total
    return [bit for bit in range(total.bit_length()) if total >> bit & 1]
