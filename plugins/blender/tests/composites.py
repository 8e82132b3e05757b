"""Sets the little shot up for compositing, and says what its composite should be."""

from pathlib import Path
from typing import Any

import bpy
import flowabs_blender
import numpy as np
import OpenImageIO as oiio
import shot
from flowabs_blender import import_export

import flowabs_nodes as fa

#: A picture with lines where objects end, poster paint on what is near, beside the albedo: it needs all four passes.
PASSES = {
    "format": "flowabs.graph/1",
    "name": "passes",
    "reference_size": {"height": 54},
    "nodes": {
        "plate": {"type": "read@1"},
        "albedo": {"type": "read@1", "params": {"layer": "albedo"}},
        "depth": {"type": "read_depth@1"},
        "ids": {"type": "read_id@1", "params": {"layer": "cryptomatte"}},
        "near": {"type": "matte@1", "inputs": {"image": "depth"}, "params": {"low": 9, "high": 7}},
        "thing": {"type": "matte@1", "inputs": {"image": "ids"}, "params": {"low": 0, "high": 4e9}},
        "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
        "lines": {"type": "fdog@1", "inputs": {"image": "plate", "flow": "flow"}},
        "both": {"type": "merge@1", "inputs": {"A": "thing", "B": "near"}, "params": {"operation": "multiply"}},
        "flat": {"type": "quantize@1", "inputs": {"image": "albedo", "mask": "both"}},
        "comp": {"type": "composite@1", "inputs": {"image": "flat", "lines": "lines"}},
        "out": {"type": "write@1", "inputs": {"image": "comp"}},
    },
}


def with_layers(**layers: str) -> dict[str, Any]:
    """Return the graph with other layers for the nodes that read."""
    nodes = {name: {**body} for name, body in PASSES["nodes"].items()}
    for name, layer in layers.items():
        nodes[name]["params"] = {"layer": layer}
    return {**PASSES, "nodes": nodes}


def set_up(folder: str, graph: dict[str, Any] | None = None, **options: Any) -> tuple[Any, Any]:
    """Return the shot and the scene that composites it, which writes floats."""
    first = bpy.context.scene
    tree, _ = import_export.new_tree(graph or PASSES, "graph")
    second = flowabs_blender.set_up_compositing(first, tree, folder=folder, **options)
    shot.as_float(second)
    return first, second


def story(first: Any, second: Any) -> dict[str, Any]:
    """Return what the tests look at."""
    return {
        "passes": first.render.filepath,
        "composite": second.render.filepath,
        "problems": second.flowabs_compositing.problems,
        "passes_problems": first.flowabs_compositing.problems,
    }


def pixels_of(file: Path) -> Any:
    picture = oiio.ImageBuf(str(file))
    assert picture.read(force=True, convert=oiio.FLOAT), picture.geterror()
    return picture.get_pixels(oiio.FLOAT)


def composite(told: dict[str, Any], frame: int) -> Any:
    return pixels_of(shot.frame_file(told["composite"], frame))


def expected(told: dict[str, Any], frame: int, graph: dict[str, Any] | None = None) -> Any:
    """Return what the graph makes of a frame's file without Blender, with alpha, on the whole frame."""
    loaded = fa.load_graph(graph or PASSES)
    file = str(shot.frame_file(told["passes"], frame))
    loaded = loaded.with_set({f"{name}.file": file for name in ("plate", "albedo", "depth", "ids")})
    image = loaded.run(frame, outputs="comp")["comp"]
    x, y, width, height = image.data_window
    whole = np.zeros((27, 48, 4), np.float32)
    whole[y : y + height, x : x + width] = image.to_array(channels="RGBA")
    return whole
