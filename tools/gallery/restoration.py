"""Measure Figs. 16 and 17: how near FBL and the bilateral filter bring a damaged picture to the undamaged one.

The graphs are those of the figures, with the paper's parameters. The pictures are a drawn one, flat shapes with clean
outlines as in the paper's own, and photographs, which have texture that no smoothing brings back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flowabs_nodes.color import encode_mono, srgb
from flowabs_nodes.engine import load_graph
from flowabs_nodes.graph.shipped import paper
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from tools.gallery import drawings, inputs, measures
from tools.gallery.sheet import Bytes, display

SIZE = 256
PHOTOGRAPHS = ("coffee.exr", "chelsea.png", "astronaut.jpg", "columns.jpg")


@dataclass(frozen=True)
class Damage:
    """A kind of damage to a picture, and the figure that repairs it."""

    figure: str
    words: str
    apply: Callable[[Bytes], Bytes]


NOISE = Damage("fig16", "Gaussian noise, sigma 20 of 255", drawings.noisy)
BLOCKS = Damage("fig17", "JPEG, quality 10", drawings.jpeg_damaged)


@dataclass(frozen=True)
class Restored:
    """A damaged picture and each filter's result, by "damaged", "bilateral", "fbl"."""

    pixels: dict[str, Bytes]  # on the display
    psnr: dict[str, float]  # dB, against the clean picture
    edge_error: dict[str, float]  # of its lightness, see measures.edge_error


def restore(clean: Bytes, damage: Damage) -> Restored:
    """Damage a picture, (H, W, 3) display pixels, and run the figure's graph on it."""
    damaged = damage.apply(clean)
    done = _run(damaged, damage, ("bilateral", "fbl"), {})
    pixels = {"damaged": damaged} | {name: display(image) for name, image in done.items()}
    true = _lightness(clean)
    return Restored(
        pixels,
        {name: measures.psnr(result, clean) for name, result in pixels.items()},
        {name: measures.edge_error(_lightness(result), true) for name, result in pixels.items()},
    )


def best_bilateral(clean: Bytes, damage: Damage, sigmas: Iterable[float] = (10, 20, 40, 80)) -> tuple[float, float]:
    """Return the sigma_r of the bilateral filter's best PSNR here, and the PSNR: a fairer match than the paper's 10."""
    damaged = damage.apply(clean)
    found = []
    for sigma in sigmas:
        image = _run(damaged, damage, ("bilateral",), {"bilateral.sigma_r": sigma})["bilateral"]
        found.append((measures.psnr(display(image), clean), sigma))
    psnr, sigma = max(found)
    return sigma, psnr


def flower(size: int = SIZE) -> Bytes:
    """Draw flat shapes with clean, anti-aliased outlines, a flower, a crescent and a bar: (H, W, 3) display pixels."""
    fine = 4
    y, x = (np.mgrid[: size * fine, : size * fine] + 0.5) / fine * (SIZE / size)
    picture = np.full((size * fine, size * fine, 3), (214, 196, 160), np.float64)
    dx, dy = x - 112, y - 118
    picture[np.abs((x - 40) * 0.5 + (y - 214) * 0.87) < np.where((x > 14) & (x < 110), 12, 0)] = (70, 120, 80)
    picture[np.hypot(dx, dy) < 66 + 16 * np.cos(5 * np.arctan2(dy, dx) + 0.4)] = (60, 92, 150)
    picture[np.hypot(dx, dy) < 26] = (228, 170, 60)
    picture[(np.hypot(x - 196, y - 196) < 44) & (np.hypot(x - 182, y - 182) > 34)] = (150, 52, 48)
    flat: Bytes = np.rint(picture.reshape(size, fine, size, fine, 3).mean((1, 3))).astype(np.uint8)
    return flat


def photograph(name: str, size: int = 400) -> Bytes:
    """Return the top left of a picture in ``docs/pictures``, at most ``size`` wide and high, as display pixels."""
    image = read_image(inputs.pictures() / name, settings=Settings(), note=_quiet, warn=_quiet)
    return np.ascontiguousarray(display(image)[:size, :size])


def _run(damaged: Bytes, damage: Damage, outputs: Iterable[str], values: Mapping[str, float]) -> dict[str, Image]:
    graph = load_graph(paper()[damage.figure])
    return graph.run(given={"plate": _plate(damaged)}, outputs=outputs, set=values, on_event=_quiet)


def _plate(pixels: Bytes) -> Image:
    return Image.from_array(srgb.linear(pixels.astype(np.float32) / np.float32(255)))


def _lightness(pixels: Bytes) -> drawings.Array:
    return encode_mono(_plate(pixels).pixels)


def _quiet(message: Any) -> None:
    """Silence the log: the colour space of these pictures is known."""
