"""Makes small pictures for the compliance suite: one scene for each thing that a filter may trip over."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from flowabs_nodes.array_types import Array
from flowabs_nodes.image import Image, Origin
from flowabs_nodes.port_types import PixelType, PortType, pixel_type

#: Shapes of different colours and equal lightness; noise; soft alpha, with 0 and 1; values far above 1 and below 0.
SCENES = ("shapes", "noise", "alpha", "hdr")


def make_input(kind: PortType, scene: str, height: int, width: int) -> Image:
    """Make an image of a port type, on a data window that is not the display window, with metadata and an origin.

    Every image of one size is on the same window, so that they can go into one node.
    """
    declared = pixel_type(kind)
    if kind == "color":
        pixels, channels = _color(scene, height, width), None
    else:
        pixels, channels = _values(declared, scene, height, width), declared.typical_channels
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


def _values(declared: PixelType, scene: str, height: int, width: int) -> npt.NDArray[Any]:
    """Return pixels of any other type, (H, W, C), by its declaration: directions, areas of ids, a ring of numbers."""
    count = len(declared.typical_channels)
    if declared.unit:
        return _directions(scene, height, width, count)
    low, high = declared.usual
    shares = np.stack([_shares(scene, height, width, channel) for channel in range(count)], axis=2)
    if declared.dtype.kind == "u":
        steps = np.floor(shares.astype(np.float64) * 5) / 5  # areas of one id each
        return np.minimum(low + steps * (high - low) + 1, np.iinfo(declared.dtype).max).astype(declared.dtype)
    return np.asarray(low + (high - low) * shares, declared.dtype)


def _directions(scene: str, height: int, width: int, count: int) -> Array:
    """Return vectors of length 1, (H, W, count)."""
    y, x = _grid(height, width)
    angle = 3 * x + 2 * y * y + 1.0
    if scene == "noise":
        angle = np.random.default_rng(8).random((height, width)) * np.pi
    tilts = [np.cos(x + channel) for channel in range(count - 2)]  # how far each further axis leaves the plane
    flat = np.sqrt(np.maximum(1 - sum(tilt**2 for tilt in tilts), 0)) if tilts else 1.0
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), *tilts], axis=2).astype(np.float32)


def _shares(scene: str, height: int, width: int, channel: int) -> Array:
    """Return numbers from 0 to 1, (H, W): noise, or a soft ring, a little further to the right in each channel."""
    y, x = _grid(height, width)
    if scene == "noise":
        return np.random.default_rng(9 + channel).random((height, width), np.float32)
    ring = np.clip(6 * np.abs(np.hypot(x - 0.5 - 0.1 * channel, y - 0.4) - 0.25), 0, 1)
    return np.asarray(ring, np.float32)
