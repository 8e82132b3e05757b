"""Makes small pictures for the compliance suite: one scene for each thing that a filter may trip over."""

from __future__ import annotations

import numpy as np

from flowabs_nodes.array_types import Array
from flowabs_nodes.image import Image, Origin, PortType

#: Shapes of different colours and equal lightness; noise; soft alpha, with 0 and 1; values far above 1 and below 0.
SCENES = ("shapes", "noise", "alpha", "hdr")


def make_input(kind: PortType, scene: str, height: int, width: int) -> Image:
    """Make an image of a port type, on a data window that is not the display window, with metadata and an origin.

    Every image of one size is on the same window, so that they can go into one node.
    """
    plane = {"color": _color, "flow": _flow, "mono": _mono, "matte": _matte, "data": _data}[kind]
    pixels = plane(scene, height, width)
    channels = ("Z", "id") if kind == "data" else None
    image = Image.from_array(pixels, "lin_ap1_scene", type=kind, channels=channels)
    spec = image.spec
    spec.x, spec.y = 5, -3
    spec.full_x, spec.full_y, spec.full_width, spec.full_height = 0, 0, 2 * width, 2 * height
    spec.attribute("owner", "somebody")
    spec.attribute("shot:take", 7)
    spec.attribute("framesPerSecond", 23.976)
    spec.attribute("PixelAspectRatio", 2.0)
    return Image(image.pixels, spec, kind, colorspace=image.colorspace, origin=Origin("plate.exr"))


def on_frame(image: Image, frame: int) -> Image:
    """Return the image as another frame of its sequence has it: of its type, each pixel made from the same pixel alone.

    Frame 0 is the image itself. Of other frames numbers are smaller, and channels of directions change places; whole
    numbers, which name things, are the same on all.
    """
    pixels = image.pixels
    if frame == 0 or pixels.dtype != np.float32:
        return image
    if image.type in ("flow", "normal"):
        return image.with_pixels(np.roll(pixels, frame, axis=2))
    colors = slice(0, 3) if image.type == "color" else slice(None)
    changed = pixels.copy()
    changed[..., colors] *= np.float32(0.75 ** (1 + frame % 7))
    return image.with_pixels(changed)


def _grid(height: int, width: int) -> tuple[Array, Array]:
    y, x = np.mgrid[:height, :width].astype(np.float32)
    return (y + 0.5) / height, (x + 0.5) / width


def _color(scene: str, height: int, width: int) -> Array:
    rng = np.random.default_rng(7)
    y, x = _grid(height, width)
    if scene == "noise":
        return rng.random((height, width, 3), np.float32)
    rgb = np.stack([0.2 + 0.1 * x, 0.2 + 0.1 * y, 0.25 + 0 * x], axis=2)
    rgb[(x - 0.35) ** 2 + (y - 0.4) ** 2 < 0.06] = (0.8, 0.1, 0.05)
    rgb[(x > 0.6) & (y > 0.3)] = (0.05, 0.3, 0.7)
    rgb[(x + y > 1.1) & (x + y < 1.25)] = (0.9, 0.85, 0.7)
    rgb += rng.normal(0, 0.004, rgb.shape)
    if scene == "hdr":
        rgb *= (2.0 ** (12 * x - 4))[..., None]
        rgb[y < 0.2] -= 0.3
    if scene == "alpha":
        alpha = np.clip(1.4 - 3 * np.hypot(x - 0.5, y - 0.5), 0, 1)[..., None]
        rgb = np.concatenate([rgb * alpha, alpha], axis=2)
    return rgb.astype(np.float32)


def _flow(scene: str, height: int, width: int) -> Array:
    y, x = _grid(height, width)
    angle = 3 * x + 2 * y * y + 1.0
    if scene == "noise":
        angle = np.random.default_rng(8).random((height, width)) * np.pi
    return np.stack([np.cos(angle), np.sin(angle)], axis=2).astype(np.float32)


def _mono(scene: str, height: int, width: int) -> Array:
    return np.asarray(40 * _matte(scene, height, width) - 10, np.float32)


def _matte(scene: str, height: int, width: int) -> Array:
    y, x = _grid(height, width)
    if scene == "noise":
        return np.random.default_rng(9).random((height, width), np.float32)
    ring: Array = np.clip(6 * np.abs(np.hypot(x - 0.5, y - 0.4) - 0.25), 0, 1).astype(np.float32)
    return ring


def _data(scene: str, height: int, width: int) -> Array:
    y, x = _grid(height, width)
    return np.stack([100 * y, np.floor(4 * x)], axis=2).astype(np.float32)
