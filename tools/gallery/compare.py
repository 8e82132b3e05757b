"""Compare our lines and cartoon with what others use, in numbers: ``python -m tools.gallery.compare [FOLDER]``.

Five pictures, each at the 540 lines that the shipped graphs are meant for. Each method is a graph, so that anyone can
run it; OpenCV's stylization is called as it is. Then Figs. 16 and 17 as numbers, and Fig. 23's times from
``docs/gallery/fig23.json``. Needs the extra ``compare``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio

import flowabs_nodes
from flowabs_nodes.color import srgb
from flowabs_nodes.engine import RunnableGraph, load_graph
from flowabs_nodes.errors import FlowabsError
from flowabs_nodes.image import Image
from flowabs_nodes.io.read import read_image
from flowabs_nodes.io.settings import Settings
from tools.gallery import compare_page, inputs, measures, restoration
from tools.gallery.drawings import Array
from tools.gallery.sheet import Bytes, Tile, display, enlarged, fitted, save, sheet

LINES = 540  # the reference height of the shipped graphs
NOISE = 2.0  # sigma of what a frame is under, in 8-bit display values
DRAWS = (1, 2)
WIDTH = 280  # of a panel

#: The pictures, and the corner of what is shown of each at 1:1.
PICTURES = {
    "coffee.exr": (230, 230),
    "chelsea.png": (210, 130),
    "astronaut.jpg": (140, 10),
    "raccoon.jpg": (330, 120),
    "render.exr": (300, 60),
}


@dataclass(frozen=True)
class Method:
    """A way from a plate to a drawing or a flat picture."""

    name: str
    words: str
    run: Callable[[Image], Image]


@dataclass(frozen=True)
class Steadiness:
    """The measurements of a method on a picture; a flat picture has neither ink nor jag."""

    flicker: float
    jag: float | None = None
    ink: float | None = None


Measured = dict[str, dict[str, Steadiness]]  # by method and picture


def line_methods() -> tuple[Method, ...]:
    """Return ours, FDoG and isotropic DoG at the paper's values, isotropic DoG with our threshold, and Canny."""
    return (
        Method("lines", "graph lines, as shipped", _graph("lines", "strokes")),
        Method(
            "FDoG, paper's values",
            "3 passes, rho 0.99, tau 0.5, black and white",
            _chain(
                {
                    "flow": {"type": "etf@1", "inputs": {"image": "plate"}},
                    "made": {"type": "fdog_iterative@1", "inputs": {"image": "plate", "flow": "flow"}},
                }
            ),
        ),
        Method("DoG, paper's values", "isotropic, rho 0.99, tau 0.5, black and white", _node("dog@1")),
        Method(
            "DoG, soft",
            "isotropic, rho 1, contrast 1, softness 4: our threshold",
            _node("dog@1", rho=1, contrast=1, softness=4),
        ),
        Method("Canny", "OpenCV, sigma 1, low 0.1, high 0.2", _node("canny@1")),
    )


def color_methods() -> tuple[Method, ...]:
    """Return ours, the bilateral filter with levels, mean shift, and OpenCV's stylization."""
    levels = {"levels": 10, "softness": 0.7}
    return (
        Method("abstraction", "graph abstraction, as shipped", _graph("abstraction", "comp")),
        Method("flat", "graph flat, as shipped: no lines", _graph("flat", "flat")),
        Method(
            "bilateral, levels",
            "sigma_d 2, sigma_r 10, 5 times; 10 soft levels",
            _chain(
                {
                    "smooth": {"type": "bilateral@1", "inputs": {"image": "plate"}, "params": {"iterations": 5}},
                    "made": {"type": "quantize@1", "inputs": {"image": "smooth"}, "params": levels},
                }
            ),
        ),
        Method("mean shift", "OpenCV, spatial 10, range 5, min_region 20", _node("mean_shift@1")),
        Method("stylization", "OpenCV's, as it comes", _stylization),
    )


def picture(name: str, lines: int | None = LINES) -> Image:
    """Return a picture of ``docs/pictures``, resized to a number of lines; None leaves it as it is."""
    plate = read_image(inputs.pictures() / name, settings=Settings(), note=_quiet, warn=_quiet)
    height, width, _ = plate.pixels.shape
    if lines in (None, height):
        return plate
    size = oiio.ROI(0, round(width * lines / height), 0, lines, 0, 1, 0, 3)
    resized = oiio.ImageBufAlgo.resize(oiio.ImageBuf(np.ascontiguousarray(plate.pixels[..., :3])), roi=size)
    return Image.from_array(np.maximum(np.asarray(resized.get_pixels("float"), np.float32), 0), plate.colorspace)


def under_noise(plate: Image, draw: int, sigma: float = NOISE) -> Image:
    """Add Gaussian noise to each channel of colour, sigma in 8-bit display values, without rounding or clipping.

    Alpha stays: noise there would let through light from behind the plate, far above what its dark parts have.
    """
    codes = srgb.encoded(np.ascontiguousarray(plate.pixels[..., :3]))
    noise = np.random.default_rng(draw).standard_normal(codes.shape).astype(np.float32)
    pixels = srgb.linear(codes + np.float32(sigma / 255) * noise)
    return Image.from_array(np.concatenate([pixels, plate.pixels[..., 3:]], axis=2), plate.colorspace)


def steadiness_of_lines(method: Method, plate: Image) -> Steadiness:
    """Measure the flicker between two draws of noise, and jag and ink of the drawing without noise."""
    one, other = (method.run(under_noise(plate, draw)).pixels[..., 0] for draw in DRAWS)
    drawing = method.run(plate).pixels[..., 0]
    return Steadiness(measures.flicker(one, other), measures.jag(drawing), float(1 - drawing.mean()))


def steadiness_of_color(method: Method, plate: Image) -> Steadiness:
    """Measure the mean |difference| between two draws of noise, in 8-bit display values: the input's is 2.26."""
    one, other = (_display_codes(method.run(under_noise(plate, draw))) for draw in DRAWS)
    return Steadiness(float(np.abs(one - other).mean()))


def main(folder: Path) -> None:
    """Write the page, its sheets, and ``numbers.json``."""
    drawn, flat = line_methods(), color_methods()
    lines: Measured = {method.name: {} for method in drawn}
    smaller: Measured = {drawn[0].name: {}}
    color: Measured = {method.name: {} for method in flat}
    sheets = []
    for name, corner in PICTURES.items():
        plate = picture(name)
        for method in drawn:
            lines[method.name][name] = steadiness_of_lines(method, plate)
        smaller[drawn[0].name][name] = steadiness_of_lines(drawn[0], picture(name, None))
        for method in flat:
            color[method.name][name] = steadiness_of_color(method, plate)
        captions = {
            method.name: f"flicker {lines[method.name][name].flicker:.3f}, jag {lines[method.name][name].jag:.1f}"
            for method in drawn
        }
        sheets.append(_sheet(plate, corner, (drawn, flat), captions, folder / f"{Path(name).stem}.jpg"))
        print(f"{sheets[-1]}  {sheets[-1].stat().st_size / 1000:.0f} kB", flush=True)
    restored = _restored(folder)
    numbers = {"lines": _plain(lines), "own size": _plain(smaller), "color": _plain(color), "restoration": restored}
    (folder / "numbers.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    times = json.loads((folder.parent / "gallery" / "fig23.json").read_text(encoding="utf-8"))
    words = {method.name: method.words for method in (*drawn, *flat)}
    (folder / "README.md").write_text(compare_page.page(numbers, words, times), encoding="utf-8")


def _plain(found: Measured) -> dict[str, dict[str, dict[str, float]]]:
    return {
        method: {
            name: {key: round(number, 4) for key, number in vars(value).items() if number is not None}
            for name, value in values.items()
        }
        for method, values in found.items()
    }


def _restored(folder: Path) -> dict[str, dict[str, dict[str, float]]]:
    """Restore a drawing and photographs as in Figs. 16 and 17: return the numbers, write a sheet of the drawing."""
    pictures = {"flower (drawn)": restoration.flower()}
    pictures |= {name: restoration.photograph(name) for name in restoration.PHOTOGRAPHS}
    found: dict[str, dict[str, dict[str, float]]] = {}
    rows = []
    for damage in (restoration.NOISE, restoration.BLOCKS):
        found[damage.figure] = {}
        for name, clean in pictures.items():
            done = restoration.restore(clean, damage)
            sigma, best = restoration.best_bilateral(clean, damage)
            values = {f"{kind} dB": value for kind, value in done.psnr.items()}
            values |= {f"{kind} edges": value for kind, value in done.edge_error.items()}
            values |= {"best bilateral dB": best, "best bilateral sigma_r": sigma}
            found[damage.figure][name] = {key: round(value, 3) for key, value in values.items()}
            if name not in restoration.PHOTOGRAPHS:
                rows += [
                    [Tile(clean, "clean")]
                    + [Tile(pixels, kind, f"{done.psnr[kind]:.1f} dB") for kind, pixels in done.pixels.items()],
                    [Tile(enlarged(pixels, (60, 60, 85, 85), 3), "") for pixels in (clean, *done.pixels.values())],
                ]
    save(sheet(rows), folder / "restoration.jpg")
    return found


def _sheet(
    plate: Image,
    corner: tuple[int, int],
    families: Iterable[tuple[Method, ...]],
    captions: Mapping[str, str],
    file: Path,
) -> Path:
    """Write a sheet with a row of each family of methods, and a row of each at 1:1."""
    rows = []
    for methods in families:
        made = [("input", display(plate)), *((method.name, display(method.run(plate))) for method in methods)]
        box = (*corner, WIDTH, WIDTH * 2 // 3)
        rows.append([Tile(fitted(pixels, WIDTH), name, captions.get(name, "")) for name, pixels in made])
        rows.append([Tile(enlarged(pixels, box), "1:1") for _, pixels in made])
    return save(sheet(rows), file, limit=380_000)


def _graph(name: str, output: str) -> Callable[[Image], Image]:
    graph = load_graph(name)
    return lambda plate: _run(graph, plate, output)


def _node(kind: str, **params: Any) -> Callable[[Image], Image]:
    return _chain({"made": {"type": kind, "inputs": {"image": "plate"}, "params": params}})


def _chain(nodes: Mapping[str, Any]) -> Callable[[Image], Image]:
    """Return a graph of these nodes, of which ``made`` is the last."""
    ends = {"plate": {"type": "read@1"}, "out": {"type": "write@1", "inputs": {"image": "made"}}}
    graph = load_graph({"format": "flowabs.graph/1", "name": "compared", "nodes": ends | dict(nodes)})
    return lambda plate: _run(graph, plate, "made")


def _run(graph: RunnableGraph, plate: Image, output: str) -> Image:
    return graph.run(given={"plate": plate}, outputs=[output], on_event=_quiet)[output]


def _stylization(plate: Image) -> Image:
    """Run OpenCV's domain-transform stylization, on 8 bits."""
    from flowabs_nodes.filters.opencv import opencv

    made: Bytes = opencv("stylization").stylization(np.ascontiguousarray(display(plate)[..., ::-1]))[..., ::-1]
    return Image.from_array(srgb.linear(made.astype(np.float32) / np.float32(255)))


def _display_codes(image: Image) -> Array:
    return np.asarray(255 * np.clip(srgb.encoded(image.pixels[..., :3]), 0, 1), np.float32)


def _quiet(message: Any) -> None:
    """Silence the log: the colour space of these pictures is known."""


if __name__ == "__main__":
    docs = Path(flowabs_nodes.__file__).resolve().parent.parent / "docs"
    parser = argparse.ArgumentParser(prog="python -m tools.gallery.compare", description="Makes docs/compare again.")
    parser.add_argument("folder", nargs="?", type=Path, default=docs / "compare", help="where to (docs/compare)")
    given = parser.parse_args()
    try:
        main(given.folder)
    except FlowabsError as error:
        sys.exit(f"flowabs: {error}")
