"""A small shot on disk whose ground and disc move, with its passes, and graphs that steady it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from flowabs_nodes.image import Image
from flowabs_nodes.io.output_image import build_picture
from flowabs_nodes.io.write import save
from tests.engine.windows import node
from tests.filters.motion.scenes import Scene

SCENE = Scene(width=40, height=28, radius=6)


def frame_file(path: Path, frame: int, seed: int | None = None) -> Path:
    """Write a frame of the shot, with its own noise: R, G, B, motion, depth and normals, in one EXR of floats."""
    noise = np.random.default_rng(frame if seed is None else seed).normal(0, 0.03, (SCENE.height, SCENE.width, 3))
    at = frame - 1003  # on which the disc is in the middle
    plate = Image.from_array((SCENE.codes(at) / 255 + noise).clip(0, None).astype(np.float32))
    passes = {name: Image.from_array(getattr(SCENE, name)(at), type=name) for name in ("motion", "depth", "normal")}
    path.parent.mkdir(parents=True, exist_ok=True)
    save(build_picture(plate, passes, data_type="float"), str(path))
    return path


def moving_shot(folder: Path, frames: Iterable[int]) -> str:
    """Write frames of the shot and return their pattern."""
    for frame in frames:
        frame_file(folder / f"move.{frame:04d}.exr", frame)
    return str(folder / "move.####.exr")


def steady(shot: str, *, flow: bool = False, missing: str = "error", **params: Any) -> dict[str, Any]:
    """Return the nodes of a graph: plate -> steady -> soft -> out; motion comes from the passes, or from the plate."""
    read = {"file": shot, "missing": missing}
    nodes = {
        "plate": node("read", **read),
        "motion": node("optical_flow", "plate", preset="ultrafast") if flow else node("read_motion", **read),
        "steady": node("motion_window", "plate", {"motion": "motion"}, **params),
        "soft": node("blur", "steady"),
        "out": node("write", "soft", {"confidence": "steady.confidence"}, data_type="float"),
    }
    if not flow:
        nodes["depth"] = node("read_depth", **read)
        nodes["steady"]["inputs"]["depth"] = "depth"
    return nodes
