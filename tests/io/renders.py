"""Make small renders as each renderer names its passes: EXR files by the OpenEXR module."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tests.io.files import Planes, colors, exr, parts, planes

HEIGHT, WIDTH = 24, 32
#: Above 2**24, and the largest; as float bits one of them is a negative number.
CRATE, BALL, FLOOR = 0x956D4CBD, 0x645D3BC4, 2**24 + 1
MANIFEST = '{"crate":"956d4cbd","ball":"645d3bc4"}'


def numbers(count: int, seed: int, low: float = -1.0, high: float = 1.0) -> np.ndarray:
    """Return (H, W, count) of float32 noise."""
    return np.random.default_rng(seed).uniform(low, high, (HEIGHT, WIDTH, count)).astype(np.float32)


def depth(dtype: Any = np.float32) -> np.ndarray:
    """Return depths, (H, W), with a background of 1e10 on the right: in half it becomes Inf."""
    z = numbers(1, 11, 2, 40)[..., 0]
    z[:, 20:] = 1e10
    with np.errstate(over="ignore"):
        return z.astype(dtype)


NORMAL = numbers(3, 12)
VECTOR = numbers(4, 13, -9, 9)
INDEX = np.random.default_rng(14).integers(0, 9, (HEIGHT, WIDTH)).astype(np.float32)
IDS = np.where(np.arange(WIDTH) < 9, np.uint32(CRATE), np.uint32(FLOOR))[None].repeat(HEIGHT, 0)
ARNOLD_IDS = np.where(np.arange(WIDTH) < 9, np.uint32(2**32 - 1), np.uint32(FLOOR))[None].repeat(HEIGHT, 0)


def crypto() -> dict[str, tuple[np.ndarray, ...]]:
    """Return the two levels of a Cryptomatte, each R, G, B, A.

    On the left the crate covers .7, in the middle the ball .4 and the crate .3, on the right the ball .3, .2 and .1 of
    others, so that .4 are background.
    """
    first = np.full((HEIGHT, WIDTH), BALL, np.uint32)
    first[:, :9] = CRATE
    second = np.full((HEIGHT, WIDTH), CRATE, np.uint32)
    second[:, :9] = BALL
    shares = np.zeros((HEIGHT, WIDTH, 3), np.float32)
    shares[:, :9] = (0.7, 0.1, 0)
    shares[:, 9:20] = (0.4, 0.3, 0.1)
    shares[:, 20:] = (0.3, 0.2, 0.1)
    one, two, three = (np.ascontiguousarray(shares[..., i]) for i in range(3))  # the writer ignores strides
    zero = np.zeros((HEIGHT, WIDTH), np.float32)
    third = np.full((HEIGHT, WIDTH), FLOOR, np.uint32).view(np.float32)
    return {
        "00": (first.view(np.float32), one, second.view(np.float32), two),
        "01": (third, three, zero, zero),
    }


def crypto_planes(name: str, letters: str = "rgba") -> dict[str, Planes]:
    """Return the channels of each level of a Cryptomatte, by the level's name."""
    return {
        name + level: {f"{name}{level}.{letter}": plane for letter, plane in zip(letters, each, strict=True)}
        for level, each in crypto().items()
    }


def crypto_header(name: str) -> dict[str, str]:
    """Return the attributes of a Cryptomatte."""
    about = {"name": name, "hash": "MurmurHash3_32", "conversion": "uint32_to_float32", "manifest": MANIFEST}
    return {f"cryptomatte/abc1234/{key}": value for key, value in about.items()}


def blender_passes(index: str, view: str = "ViewLayer") -> dict[str, Planes]:
    """Return Blender's passes of a view layer, by the name of each."""
    return {
        f"{view}.Combined": planes(colors(channels=4), layer=f"{view}.Combined"),
        f"{view}.Depth": {f"{view}.Depth.Z": depth()},
        f"{view}.Normal": planes(NORMAL, "XYZ", f"{view}.Normal"),
        f"{view}.Vector": planes(VECTOR, "XYZW", f"{view}.Vector"),
        f"{view}.{index}": {f"{view}.{index}.X": INDEX},
        **crypto_planes(f"{view}.CryptoObject"),
        **crypto_planes(f"{view}.CryptoMaterial"),
    }


def blender45(path: Path, *views: str) -> Path:
    """Write a render as Blender 4.5 does: one part."""
    channels: Planes = {}
    for view in views or ("ViewLayer",):
        for each in blender_passes("IndexOB", view).values():
            channels |= each
    return exr(path, channels, **crypto_header(f"{(views or ('ViewLayer',))[0]}.CryptoObject"))


def blender5(path: Path, *views: str) -> Path:
    """Write a render as Blender 5 does: a part for each pass, the Cryptomatte's manifest in the first one."""
    passes: dict[str, Planes] = {}
    for view in views or ("ViewLayer",):
        passes |= blender_passes("Object Index", view)
    first = crypto_header(f"{(views or ('ViewLayer',))[0]}.CryptoObject")
    return parts(path, *((name, each, {} if i else first) for i, (name, each) in enumerate(passes.items())))


def arnold(path: Path) -> Path:
    """Write a render as Arnold does: ID as uint."""
    passes = (
        {"Z": depth(), "ID": ARNOLD_IDS} | planes(NORMAL, "XYZ", "N") | planes(VECTOR[..., :2], "XY", "motionvector")
    )
    for each in crypto_planes("crypto_object", "RGBA").values():
        passes |= each
    return exr(path, planes(colors(channels=4)) | passes, **crypto_header("crypto_object"))


def renderman(path: Path) -> Path:
    """Write a render as RenderMan does."""
    passes = {"z": depth(), "id": INDEX} | planes(NORMAL, ("x", "y", "z"), "Nn")
    passes |= planes(VECTOR[..., :2], ("x", "y"), "motionBack") | planes(VECTOR[..., 2:], ("x", "y"), "motionFore")
    return exr(path, planes(colors(channels=4)) | passes)


def vray(path: Path) -> Path:
    """Write a render as V-Ray does: a grey depth and grey ids in red, green and blue."""
    grey = ("red", "green", "blue")
    passes = planes(np.repeat(depth()[..., None], 3, axis=2), grey, "VRayZDepth")
    passes |= planes(NORMAL, "XYZ", "normals") | planes(VECTOR[..., :3], "XYZ", "velocity")
    passes |= planes(np.repeat(INDEX[..., None], 3, axis=2), grey, "Render ID")
    return exr(path, planes(colors(channels=4)) | passes)


def karma(path: Path) -> Path:
    """Write a render with Houdini's names, a part for each pass, channels without a layer in front."""
    return parts(
        path,
        ("C", planes(colors(channels=4)), {}),
        ("Pz", {"Z": depth()}, {}),
        ("N", planes(NORMAL, ("x", "y", "z")), {}),
        ("motionvector", planes(VECTOR[..., :2], ("x", "y")), {}),
        ("primid", {"Y": INDEX - 1}, {}),
    )
